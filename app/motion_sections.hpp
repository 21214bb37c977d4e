// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/calibrate.hpp"
#include "report/report_content.hpp"

#include <vector>

namespace twang::app {

/// What the report shows of one recording's motion: the trace with its fit, the spectrum with the
/// sinusoids and the checks of the strongest, and how that one changes with its amplitude.
[[nodiscard]] std::vector<ReportSection> motion_sections(const Repeat& repeat);

}  // namespace twang::app
