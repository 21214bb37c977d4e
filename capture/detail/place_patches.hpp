// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/find_layout.hpp"

#include <Eigen/Core>

#include <map>
#include <string>

namespace twang::detail {

/// What is seen of a film's picture and what is known of it beforehand.
struct PatchSearch {
  const LumaFrame& frame;
  const Rig& rig;
  const std::map<std::string, Eigen::Vector2d>& start_px;  ///< stated places, by id [px]
  const std::string& film;                                 ///< name of the film in messages
  const std::string& picture;                              ///< name of the picture in messages
};

/// A rig's markers but the patches.
[[nodiscard]] Rig without_patches(const Rig& rig);

/// The layout of the whole rig, made of that of its printed markers: each patch is cut out of the
/// picture at its stated place, else where two or more printed markers put it. Size and turn are
/// those of the map from the rest plane. A patch on a part that is bent moves with the printed
/// markers near it.
///
/// @param printed  layout of `without_patches(rig)`; patches are placed if it is usable
/// @return         not usable if a patch has too little texture to fix both coordinates, or leaves
///                 the picture
/// @throws InputError for what no picture can mend: neither a stated place nor two printed markers,
///                    or nothing to give the scale
[[nodiscard]] PartialLayout place_patches(const PatchSearch& search, PartialLayout printed);

/// Root mean square of a picture's slope within a marker's square, in the direction in which it is
/// least: what fixes the coordinate that is known worst [grey levels/px].
[[nodiscard]] double least_slope(const LumaFrame& frame, const MarkerPlacement& placement);

}  // namespace twang::detail
