// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace twang::detail {

/// `text` for the inside of an element or of a quoted attribute: & < > " ' become references.
[[nodiscard]] std::string escape_html(std::string_view text);

/// `text` as a JSON string, quotes included, that no HTML parser takes for markup even inside a
/// script element: every < is written \u003c. Bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string json_string_for_script(std::string_view text);

/// `value` with at most seven significant digits as JSON; what is not finite is `null`.
[[nodiscard]] std::string json_number(double value);

/// RFC 4648 text of `bytes`.
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace twang::detail
