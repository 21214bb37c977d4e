// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/video_reader.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <map>
#include <string>

namespace twang::detail {

/// @throws InputError if the rig lacks markers or camera, or has a marker of which there is no
/// picture
void check_markers(const Rig& rig);

/// @throws InputError if a stated start names no marker of the rig or lies outside the picture
void check_starts(const LumaFrame& frame,
                  const Rig& rig,
                  const std::map<std::string, Eigen::Vector2d>& start_px);

}  // namespace twang::detail
