/* Irradiance behind a disk, estimated:
 *
 *     cc -O2 -o eclipse eclipse.c -lm
 *     etendue judge penumbra/eclipse -- ./eclipse
 *
 * The room (metres): a disk source of radius 0.5 at height 2 that faces down, 1 W/m2; a disk of radius 0.35 at height 1. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>

static const double SOURCE_RADIUS = 0.5, SOURCE_HEIGHT = 2.0;
static const double OCCLUDER_RADIUS = 0.35, OCCLUDER_HEIGHT = 1.0;
static const double TWO_PI = 6.283185307179586;

/* SplitMix64 (Steele, Lea & Flood 2014), in [0, 1). */
static double unit(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* Mean of A M cos_i cos_s / (pi d^2) over points that are uniform on the source. */
static double estimate(const double x[3], const double n[3], long samples, uint64_t seed) {
    double total = 0.0;
    for (long k = 0; k < samples; k++) {
        double radius = SOURCE_RADIUS * sqrt(unit(&seed));
        double turn = TWO_PI * unit(&seed);
        double dx = radius * cos(turn) - x[0], dy = radius * sin(turn) - x[1], dz = SOURCE_HEIGHT - x[2];
        /* Where the shadow ray crosses the plane of the occluder. */
        double t = (OCCLUDER_HEIGHT - x[2]) / dz;
        if (t > 0.0 && t < 1.0 && hypot(x[0] + t * dx, x[1] + t * dy) < OCCLUDER_RADIUS)
            continue;
        double facing = dx * n[0] + dy * n[1] + dz * n[2];
        if (facing > 0.0 && dz > 0.0) {
            double d2 = dx * dx + dy * dy + dz * dz;
            total += facing * dz / (d2 * d2);
        }
    }
    return SOURCE_RADIUS * SOURCE_RADIUS * total / (double)samples;
}

int main(void) {
    char header[256];
    long point, samples, replicate;
    unsigned long long seed;
    double x[3], n[3];

    if (!fgets(header, sizeof header, stdin))
        return 1;
    puts("point,replicate,samples,value");
    while (scanf("%ld,%lf,%lf,%lf,%lf,%lf,%lf,%ld,%ld,%llu", &point, &x[0], &x[1], &x[2], &n[0], &n[1], &n[2], &samples,
                 &replicate, &seed) == 10)
        printf("%ld,%ld,%ld,%.17g\n", point, replicate, samples, estimate(x, n, samples, seed));
    return 0;
}
