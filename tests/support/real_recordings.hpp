// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace twang::test {

/// The folder of real recordings beside the checkout, or that named by TWANG_REAL_DATA; empty if
/// there is none.
[[nodiscard]] std::filesystem::path real_recordings();

}  // namespace twang::test
