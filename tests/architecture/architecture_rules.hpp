// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace twang::test {

/// What the `#include`s of a source tree say of its architecture.
struct ArchitectureReport {
  std::vector<std::string> violations;  ///< "FILE:LINE: what is wrong", in no order
  std::vector<std::string> arrows;      ///< "capture -> core", each once
  int num_files = 0;                    ///< sources and headers read
};

/// Reads every source and header of the rooms under `root` and holds their includes against the
/// rules:
/// - a room includes only rooms that the arrows allow, and never the `detail/` of another;
/// - what is the project's own is included in quotes, from the root;
/// - a third-party library is seen by its rooms alone;
/// - public headers (not in `detail/`, not of the command) show only the standard library and
///   Eigen;
/// - each room that is there is known to the rules.
[[nodiscard]] ArchitectureReport check_architecture(const std::filesystem::path& root);

}  // namespace twang::test
