//! The examples, run: each ends with an assertion of its own.

#[path = "../../examples/caught.rs"]
mod caught;
#[path = "../../examples/own_disk_sampling.rs"]
mod own_disk_sampling;
#[path = "../../examples/own_low_discrepancy.rs"]
mod own_low_discrepancy;
#[path = "../../examples/own_ray_tracer.rs"]
mod own_ray_tracer;
