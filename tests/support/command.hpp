// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace twang::test {

struct CommandOutcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs the built `twang` with these arguments and waits for it.
[[nodiscard]] CommandOutcome run_twang(const std::vector<std::string>& arguments);

}  // namespace twang::test
