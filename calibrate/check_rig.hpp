// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/inspect_film.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace twang {

enum class CheckVerdict { Ok, Warning, Problem };

/// "ok", "warning", "problem".
[[nodiscard]] std::string_view to_string(CheckVerdict verdict);

/// One thing that was looked at before filming.
struct CheckFinding {
  std::string subject;  ///< one word: "frequency", "markers", "scale" ...
  CheckVerdict verdict = CheckVerdict::Ok;
  std::string sentence;
};

struct CheckOptions {
  std::optional<double> capture_fps;  ///< overrules the rig's [1/s]
  std::optional<double> exposure_s;   ///< time a frame is exposed; absent: all of its interval [s]
  long max_dofs = 150000;             ///< unknowns of the mesh that predicts the motion
  ProgressCallback progress = {};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// How the rig is expected to move once it is let go.
struct ExpectedMotion {
  /// Natural frequencies of the elastic modes, ascending, at `modulus_pa`; empty: not known [Hz].
  std::vector<double> frequency_hz;
  double modulus_pa = 1.0;     ///< stated, else reported; 1 where neither is known [Pa]
  bool modulus_known = false;  ///< whether the frequencies are those of the part
  /// Of each marker from rest when the release holds the part, in the rig's order; empty: not
  /// known [m].
  std::vector<Eigen::Vector3d> amplitude_m;
  /// How much of each mode's motion at its markers the observable shows, 0 to 1; empty: not known
  /// [-].
  std::vector<double> observable_share;
  bool thin_parts_missed = false;  ///< the mesh is coarser than the thinnest solid: frequencies are
                                   ///< upper bounds
  std::string unknown_because;     ///< why something is not known, one sentence; may be empty
};

/// Eigenmodes on a moderately coarse hex20 mesh and the shape in which the release holds it (the
/// response of the first modes). Nothing is thrown for a part that cannot be meshed: it is said.
/// @throws Cancelled
[[nodiscard]] ExpectedMotion expect_motion(const Rig& rig, const CheckOptions& options = {});

struct RigCheck {
  ExpectedMotion motion;
  std::vector<CheckFinding> findings;
  /// Whether nothing stands in the way; warnings may be left.
  [[nodiscard]] bool can_be_filmed() const;
};

/// Looks a rig over before it is filmed, or with a first film of it: does the expected frequency
/// suit the frame rate, does the swing blur or leave the picture, are the markers large enough and
/// told apart, can scale be had, does the film show the observable; with a film also clock, light,
/// sharpness and steadiness.
///
/// @param film  what `inspect_film` says; nullptr: none yet
/// @throws InputError if the rig lacks markers or camera; Cancelled
[[nodiscard]] RigCheck check_rig(const Rig& rig,
                                 const CheckOptions& options = {},
                                 const FilmInspection* film = nullptr);

}  // namespace twang
