// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/picture_map.hpp"
#include "core/progress.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace twang {

/// A body that moves, as the camera sees it frame by frame.
struct BodyDrawing {
  std::vector<std::array<int, 4>> faces;  ///< quadrilaterals, by the numbers of their corners
  std::size_t first_frame = 0;            ///< of the film, to which `corners` begin to belong
  std::vector<Eigen::Matrix2Xf> corners;  ///< one a frame: in the rest plane (right, down) [m]
  PictureMap map;
  std::string name;  ///< written beside
};

/// Writes a film of the frames for which there is a body, with its outline drawn in: the border of
/// all its faces together, seen along the line of sight. The file appears whole or not at all.
///
/// @param fps  of the film written: slow enough to be watched [1/s]
/// @throws InputError if `video` cannot be read or ends before the body does, or `overlay` cannot
/// be written; Cancelled
void write_outline_overlay(const std::filesystem::path& video,
                           const std::filesystem::path& overlay,
                           const BodyDrawing& body,
                           double fps,
                           const ProgressCallback& progress = {});

}  // namespace twang
