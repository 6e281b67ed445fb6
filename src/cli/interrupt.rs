//! Ctrl-C and SIGTERM: the first asks for an end, the second is one.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use signal_hook::consts::{SIGINT, SIGTERM};

use super::commands::fault;
use super::exit;

/// What is listened for. Not a lost terminal (SIGHUP): `nohup` wants that to be overheard.
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// Whether an end was asked for. A second time ends the program at once.
pub struct Interrupt {
    asked: Arc<AtomicBool>,
    writing: Arc<Mutex<Option<PathBuf>>>,
}

impl Interrupt {
    /// From now on a signal does not end the program, but is told.
    pub fn heard() -> Result<Interrupt, u8> {
        let interrupt = Interrupt { asked: Arc::default(), writing: Arc::default() };
        interrupt.listen().map_err(|error| fault(exit::BUG, format!("signals cannot be listened for: {error}")))?;
        Ok(interrupt)
    }

    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Does what writes a report into a folder: whoever ends it at once leaves no half of one there.
    pub fn while_writing<T>(&self, folder: &Path, write: impl FnOnce() -> T) -> T {
        let set = |folder| *self.writing.lock().unwrap_or_else(PoisonError::into_inner) = folder;
        set(Some(folder.to_owned()));
        let written = write();
        set(None);
        written
    }

    #[cfg(unix)]
    fn listen(&self) -> std::io::Result<()> {
        let mut signals = signal_hook::iterator::Signals::new(SIGNALS)?;
        let (asked, writing) = (self.asked.clone(), self.writing.clone());
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                if !asked.swap(true, Ordering::Relaxed) {
                    continue;
                }
                let folder = writing.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(folder) = &*folder {
                    // As before a run: what an earlier one left is taken away. It may fail, and the end comes all the same.
                    let _ = crate::report::claim(folder);
                }
                signal_hook::low_level::exit(i32::from(exit::INTERRUPTED));
            }
        })?;
        Ok(())
    }

    /// Where no thread can wait for signals, the second ends the program within the handler.
    #[cfg(not(unix))]
    fn listen(&self) -> std::io::Result<()> {
        for signal in SIGNALS {
            let code = i32::from(exit::INTERRUPTED);
            signal_hook::flag::register_conditional_shutdown(signal, code, self.asked.clone())?;
            signal_hook::flag::register(signal, self.asked.clone())?;
        }
        Ok(())
    }
}
