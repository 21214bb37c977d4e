// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/follow_marker.hpp"
#include "capture/find_layout.hpp"
#include "rigs/rig.hpp"

#include <vector>

namespace twang::detail {

/// A follower for each marker of a rig, in its order: those found in the layout know their looks,
/// those that were not know where, how large and how turned they should be, and what is usual of
/// the others.
[[nodiscard]] std::vector<MarkerFollower> start_followers(const Rig& rig, PartialLayout layout);

}  // namespace twang::detail
