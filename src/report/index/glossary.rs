//! Words, as readers from rendering, lighting and heat transfer know them.

pub const SECTION: &str = "<section id=\"glossary\">
<h2>Glossary</h2>
<dl class=\"glossary\">
<dt>Irradiance, E</dt><dd>Power that arrives on a surface, W/m². What is measured here. The lecture that this follows writes E for exitance; standards write E for irradiance.</dd>
<dt>Exitance, M</dt><dd>Power that a source sends out of each square metre, W/m². Sources here send it out evenly in all directions of a half space (Lambertian): radiance is M/π.</dd>
<dt>Radiosity, B</dt><dd>All that leaves a surface: its own exitance, and its albedo times the irradiance; W/m².</dd>
<dt>Albedo, ϱ</dt><dd>Share of arriving light that a diffuse surface sends back, 0 to 1.</dd>
<dt>Form factor, view factor, configuration factor</dt><dd>Three names of one number: the irradiance at a patch over the exitance of a source, from 0 to 1.</dd>
<dt>Umbra, penumbra, lit</dt><dd>Where none, a part, or all of the source is seen. Below the horizon: the source is behind the surface. Edge: too near a border to tell within the exact value’s bound.</dd>
<dt>Strata</dt><dd>Equal cells of the source, one for each of N points.</dd>
<dt>Sample, N</dt><dd>A point on the source with a shadow ray to it. An estimate averages N of them (on each source).</dd>
<dt>Replicate</dt><dd>One independent repeat of all estimates. Bias and variance are taken over replicates.</dd>
<dt>Random</dt><dd>N independent points, fresh for each place on the receiver.</dd>
<dt>Shared points (<code>correlated</code>)</dt><dd>One set of N random points for all places on the receiver. As noisy as random at any one of them; neighbours err together.</dd>
<dt>Stratified</dt><dd>One point at random in each of N equal cells of the source, fresh for each place.</dd>
<dt>Bias</dt><dd>How far the mean of infinitely many estimates is from the exact value. A correct estimator has none.</dd>
<dt>Variance</dt><dd>Mean squared distance of one estimate from its mean, W²/m⁴. Its root is the noise that one sees.</dd>
<dt>Slope</dt><dd>Of log variance over log N: −1 means that twice the samples halve the variance. Expected: the same fit of the variances that the exact side predicts, over the same N.</dd>
<dt>Evidence</dt><dd>How much the data speak against a statement, as a power of ten: a correct estimator reaches x with a probability of at most 10⁻ˣ. A verdict fails at 6.</dd>
<dt>Seen from</dt><dd>The smallest deviation that would have been caught with 99 % probability: of the mean over all points / at the worst point.</dd>
<dt>Photon, light ray</dt><dd>Here a ray that leaves a source with its share of the power, and is followed through mirrors and glass until it lands.</dd>
<dt>Deposited, absorbed, escaped, terminated</dt><dd>Where its power ends: on the receiver or a diffuse surface; in a mirror, an occluder, a source or the back of a surface; nowhere, as it meets nothing any more; or beyond the limit of interactions on one path. Together they are what was emitted.</dd>
<dt>Caustic</dt><dd>Light that mirrors or glass gather. Its map holds the flux that landed in each texel of the receiver.</dd>
<dt>Next event</dt><dd>Paths from the eye that send a shadow ray to each source wherever they meet a diffuse surface; <code>eye_paths</code> wait to meet a source by chance.</dd>
</dl>
</section>
";
