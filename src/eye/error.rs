//! What keeps a case from being pictured.

use super::camera::CameraError;
use crate::errors::errors;

errors! {
    /// Why there is no picture.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum EyeError {
        #[error("the case has no [receiver] to look at and no [camera] to look through")]
        NoReceiver,
        #[error("the camera stands inside of {role} {index} (counted from 0), and sees nothing")]
        Inside { role: &'static str, index: usize },
        #[error(transparent)]
        Camera(#[from] CameraError),
    }
}
