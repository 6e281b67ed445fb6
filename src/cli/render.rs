//! `etendue render`: pictures.

use super::commands::{fault, print, select, set_threads, take};
use super::exit;
use super::options::Render;
use crate::case::Case;
use crate::report::{self, CasePictures};
use crate::statistics::Verdict;
use crate::trial::{self, Judged};

pub fn render(options: &Render) -> u8 {
    render_to_end(options).unwrap_or_else(|code| code)
}

fn render_to_end(options: &Render) -> Result<u8, u8> {
    let cases = if options.lecture { Vec::new() } else { select(&options.cases, &options.reaching)? };
    let _lock = take(&options.out)?;
    report::claim_pictures(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    set_threads(options.threads)?;
    if options.lecture {
        let lecture = trial::lecture(options.seed).map_err(|error| fault(exit::BUG, error))?;
        let written = report::write_lecture(&options.out, &lecture).map_err(|error| fault(exit::OUTPUT, error))?;
        print(&report::listed(&written))?;
        return Ok(exit::PASSED);
    }
    let pictures: Vec<CasePictures> = cases.iter().map(|case| of_case(case, options)).collect::<Result<_, u8>>()?;
    let written = report::write_pictures(&options.out, &pictures).map_err(|error| fault(exit::OUTPUT, error))?;
    print(&report::pictures_table(&pictures, &written))?;
    let any = |verdict: Verdict| {
        let receivers = pictures.iter().filter_map(|pictures| pictures.receiver.as_ref());
        receivers.into_iter().any(|of| matches!(&of.judged, Judged::By(judged) if judged.verdict == verdict))
    };
    Ok(if any(Verdict::Fail) {
        exit::FAILED
    } else if any(Verdict::Undecided) && !options.allow_undecided {
        exit::UNDECIDED
    } else {
        exit::PASSED
    })
}

fn of_case(case: &Case, options: &Render) -> Result<CasePictures, u8> {
    let settings = options.settings();
    let told = |error| fault(exit::USAGE, format!("{}: {error}", case.name));
    let camera = trial::camera_picture(case, &settings).map_err(told)?;
    let receiver = match case.configuration.receiver() {
        Some(_) => Some(trial::receiver_picture(case, &settings).map_err(told)?),
        None if camera.is_some() => None,
        None => return Err(told(crate::eye::EyeError::NoReceiver)),
    };
    Ok(CasePictures {
        name: case.name.clone(),
        digest: case.configuration.digest().to_string(),
        command: settings.command(&case.selector) + case.reach.words(),
        settings,
        camera,
        receiver,
    })
}
