// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/calibrate.hpp"
#include "report/report_content.hpp"
#include "rigs/rig.hpp"

namespace twang::app {

/// What the report of a calibration shows, in order: film, trace, spectrum, ladder, simulation over
/// track, numbers.
[[nodiscard]] ReportContent report_page(const Rig& rig, const Calibration& calibration);

}  // namespace twang::app
