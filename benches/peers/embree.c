/* Shadow rays against a mesh by Embree 3 (single rays, one thread): the rays and meshes of ours.rs, in f32.
 *
 * Build: cc -O3 -march=native embree.c -o embree -lembree3 -lm
 * Run:   ./embree disk|sphere TRIANGLES random|strat
 *
 * Source: the unit square at z = 2; occluder of radius 0.35 at z = 1; 65 points on x in [-1.5, 1.5]; 16,384 rays from each.
 * Rays are a function of their index (SplitMix64), prepared outside the clock. One line of JSON: median of seven rounds. */
#include <embree3/rtcore.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { POINTS = 65, RAYS = 16384, ROUNDS = 7 };
static const double TURN = 6.283185307179586;

static uint64_t mix(uint64_t i) {
    uint64_t z = (i + 1) * 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static float across(long ray) { return -1.5f + 3.0f * (float)(ray / RAYS) / 64.0f; }

/* Rings of a polygon: spokes corners in each of as many rings. */
static long disk(RTCGeometry geometry, long wanted) {
    long n = wanted == 100000 ? 224 : (long)floor(sqrt(wanted / 2.0) + 0.5), triangles = n * (2 * n - 1);
    float *v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 1 + n * n);
    unsigned *f = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles);
    v[0] = v[1] = 0, v[2] = 1;
    for (long i = 1; i <= n; i++)
        for (long j = 0; j < n; j++) {
            float *p = v + 3 * (1 + (i - 1) * n + j);
            p[0] = (float)(0.35 * i / n * cos(TURN * j / n)), p[1] = (float)(0.35 * i / n * sin(TURN * j / n)), p[2] = 1;
        }
#define AT(i, j) (unsigned)(1 + ((i)-1) * n + (j) % n)
    for (long j = 0; j < n; j++) *f++ = 0, *f++ = AT(1, j), *f++ = AT(1, j + 1);
    for (long i = 1; i < n; i++)
        for (long j = 0; j < n; j++) {
            *f++ = AT(i, j), *f++ = AT(i + 1, j), *f++ = AT(i + 1, j + 1);
            *f++ = AT(i, j), *f++ = AT(i + 1, j + 1), *f++ = AT(i, j + 1);
        }
#undef AT
    return triangles;
}

static float bump(double polar, double turn) { return (float)(0.35 * (1 + 0.1 * sin(7 * polar) * sin(9 * turn))); }

static long sphere(RTCGeometry geometry, long wanted) {
    long n = (long)floor(sqrt((double)wanted) + 0.5), rows = n / 2 + 1, triangles = 2 * n * (rows - 1);
    float *v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 2 + n * (rows - 1));
    unsigned *f = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles);
    v[0] = v[1] = v[3] = v[4] = 0, v[2] = 1 + bump(0, 0), v[5] = 1 - bump(TURN / 2, 0);
    for (long i = 1; i < rows; i++)
        for (long j = 0; j < n; j++) {
            double polar = TURN / 2 * i / rows, turn = TURN * j / n;
            float r = bump(polar, turn), *p = v + 3 * (2 + (i - 1) * n + j);
            p[0] = (float)(r * sin(polar) * cos(turn)), p[1] = (float)(r * sin(polar) * sin(turn));
            p[2] = (float)(1 + r * cos(polar));
        }
#define AT(i, j) (unsigned)(2 + ((i)-1) * n + (j) % n)
    for (long j = 0; j < n; j++) *f++ = 0, *f++ = AT(1, j), *f++ = AT(1, j + 1);
    for (long i = 1; i < rows - 1; i++)
        for (long j = 0; j < n; j++) {
            *f++ = AT(i, j), *f++ = AT(i + 1, j), *f++ = AT(i + 1, j + 1);
            *f++ = AT(i, j), *f++ = AT(i + 1, j + 1), *f++ = AT(i, j + 1);
        }
    for (long j = 0; j < n; j++) *f++ = 1, *f++ = AT(rows - 1, j + 1), *f++ = AT(rows - 1, j);
#undef AT
    return triangles;
}

static int by_size(const void *a, const void *b) {
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

int main(int words, char **word) {
    if (words != 4) return fprintf(stderr, "usage: embree disk|sphere TRIANGLES random|strat\n"), 2;
    int strata = !strcmp(word[3], "strat");
    RTCDevice device = rtcNewDevice("threads=1");
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    long triangles = (strcmp(word[1], "sphere") ? disk : sphere)(geometry, atol(word[2]));
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    double begin = now();
    rtcCommitGeometry(geometry), rtcAttachGeometry(scene, geometry), rtcCommitScene(scene);
    double build = now() - begin;
    long rays = (long)POINTS * RAYS, hits = 0;
    float *x = malloc(4 * rays), *y = malloc(4 * rays);
    for (long i = 0; i < rays; i++) {
        uint64_t h = mix((uint64_t)i);
        float u = (float)(h >> 40) * 0x1p-24f, v = (float)((h >> 16) & 0xffffff) * 0x1p-24f;
        if (strata) { /* a jittered grid of 128 x 128, its cells in Morton order */
            long k = i % RAYS, cx = 0, cy = 0;
            for (int b = 0; b < 12; b++) cx |= (k >> (2 * b) & 1) << b, cy |= (k >> (2 * b + 1) & 1) << b;
            u = ((float)cx + u) / 128, v = ((float)cy + v) / 128;
        }
        x[i] = (u - 0.5f) - across(i), y[i] = v - 0.5f;
    }
    double seconds[ROUNDS];
    for (int round = -1; round < ROUNDS; round++) { /* the first warms up */
        struct RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        begin = now(), hits = 0;
        for (long i = 0; i < rays; i++) {
            struct RTCRay ray;
            memset(&ray, 0, sizeof ray);
            ray.org_x = across(i), ray.dir_x = x[i], ray.dir_y = y[i], ray.dir_z = 2, ray.tfar = 1, ray.mask = ~0u;
            rtcOccluded1(scene, &context, &ray);
            hits += ray.tfar < 0;
        }
        if (round >= 0) seconds[round] = now() - begin;
    }
    qsort(seconds, ROUNDS, sizeof *seconds, by_size);
    printf("{\"who\":\"embree %ld\",\"mesh\":\"%s\",\"order\":\"%s\",\"tris\":%ld,\"hits\":%ld,\"build_ms\":%.1f,\"mrays_per_s\":%.3f}\n",
           (long)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION), word[1], word[3], triangles, hits, build * 1e3,
           rays / seconds[ROUNDS / 2] / 1e6);
    return 0;
}
