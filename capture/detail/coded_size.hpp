// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace twang::detail {

/// What a picture took to code.
struct CodedPicture {
  long bytes = 0;  ///< 0 if unknown
  char as = '?';   ///< see LumaFrame::coded_as
  int blocks = 0;  ///< of 16 x 16 px that it shows; 0 if unknown
};

/// What the coder says on each picture being a repeat of the one before, as a logarithm of odds;
/// 0 where it says nothing.
///
/// Of two pictures that are the same one costs next to nothing, which one is the coder's choice,
/// and the other as much as a picture does, or more where it stands for both; of two that are not
/// both cost what pictures of their type do around them. The sign of the difference is free, so is
/// its size from film to film: a strong compression leaves little to save. So it counts the less
/// the fewer bytes there are, and speaks against a repeat where the coder is known to leave honest
/// pictures as they were: with next to no bytes a block, and before a picture coded by itself, as
/// nothing refers to it. It is evidence beside what moves, no more.
[[nodiscard]] std::vector<double> repeat_evidence(const std::vector<CodedPicture>& pictures);

}  // namespace twang::detail
