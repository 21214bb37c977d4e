// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

/// The observable's column in a trace: `observable_mm` or `observable_rad`.
[[nodiscard]] std::string observable_column(ObservableKind kind);
/// Its unit at the user's edge: "mm" or "rad".
[[nodiscard]] std::string observable_unit(ObservableKind kind);

/// The scalar observable from marker positions: the one function that film, simulation and
/// validation share.
///
///     displacement   (x - x_rest) . direction / |direction|                                   [m]
///     angle          turn of the line a -> b from rest, in the image plane, anticlockwise as seen
///     in the image,
///                    in (-pi, pi] [rad]
///
/// Coordinates the image does not show take no part: positions and the direction are projected on
/// the plane of `image_right` and `image_down` for the angle; for the displacement the direction
/// decides alone.
///
/// @param rig        its observable, camera (axes only; the default axes if absent) and marker rest
/// positions are used
/// @param positions  one for each marker of the observable, in its order, rig frame [m]
/// @param rest       the same at rest [m]
/// @throws InputError if the rig has no observable or the sizes disagree
[[nodiscard]] double evaluate_observable(const Rig& rig,
                                         const std::vector<Eigen::Vector3d>& positions,
                                         const std::vector<Eigen::Vector3d>& rest);

/// Derivative of the observable with respect to the positions of its markers, (3 x markers), at
/// `positions`. Unit: 1 for a displacement, [rad/m] for an angle.
[[nodiscard]] Eigen::Matrix3Xd observable_gradient(const Rig& rig,
                                                   const std::vector<Eigen::Vector3d>& positions);

/// Takes jumps of 2 pi out of a sequence of angles, passing over nan; in place. [rad]
void unwrap(std::vector<double>& angles);

}  // namespace twang
