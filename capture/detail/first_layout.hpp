// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/find_layout.hpp"
#include "capture/video_reader.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace twang::detail {

/// The first frame of a film that shows where the rig's markers are.
struct FirstLayout {
  std::size_t frame = 0;
  PartialLayout layout;
  /// Where it is the film's very first frame: the reader that has just read it, to go on with.
  std::unique_ptr<VideoReader> reader = nullptr;
  LumaFrame shown = {};  ///< that frame, valid until the reader reads on
};

/// Finds it: the first frame in which enough markers are in plain view.
///
/// The whole picture is searched in every one of the first frames, then ever more seldom; when one
/// is found at last, the frames passed over are looked at too. So a long film without a usable
/// frame costs little more than its decoding.
///
/// @throws InputError if there is no such frame, naming the marker and what the best frame showed
FirstLayout find_first_layout(const Rig& rig,
                              const std::filesystem::path& video,
                              const std::map<std::string, Eigen::Vector2d>& start_px,
                              const ProgressCallback& progress);

}  // namespace twang::detail
