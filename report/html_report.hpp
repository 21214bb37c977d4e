// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "report/report_content.hpp"

#include <string>

namespace twang {

/// The report as one HTML file that needs nothing else: styles, pictures, data and the chart
/// library are inside it.
[[nodiscard]] std::string render_html(const ReportContent& content);

}  // namespace twang
