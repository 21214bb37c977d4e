// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/render_film.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace twang {

struct RenderOptions {
  ElementKind element = ElementKind::Hex20;
  std::optional<double> dx_m;  ///< absent: the smallest edge of the rig's solids [m]
  double amplitude = 1.0;      ///< factor on the rig's release: displacement or force [-]
  double hold_s = 0.1;         ///< held deflected this long before it is let go [s]
  int num_modes = 12;          ///< eigenmodes that take part
  FilmOptions film;
  LadderOptions ladder;  ///< for the limit modulus of the truth file
  ProgressCallback progress = {};
  int plucks = 1;       ///< evenly over the film; before each but the first it is pulled slowly
  double pull_s = 0.2;  ///< that long [s]
  /// Simulated (neo-Hookean, see `simulate_release`) instead of a sum of modes: right at large
  /// amplitude, and as long as it takes.
  bool nonlinear = false;
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// What a synthetic film was made from: the answer a calibration of it must find.
struct RenderTruth {
  double youngs_modulus_pa = 0.0;  ///< of the mesh that moved [Pa]
  double youngs_modulus_limit_pa =
      0.0;  ///< that the limit mesh needs for the same first frequency [Pa]
  double damping_stiffness_b_s = 0.0;  ///< b [s]
  double frequency_hz = 0.0;           ///< of the first mode, damped [Hz]
  double decay_per_s = 0.0;            ///< of the first mode [1/s]
  double hold_s = 0.0;
  double observable_at_release = 0.0;  ///< [mm] or [rad]; nan without an observable
  int num_elements = 0;
  double dx_m = 0.0;
  FilmTruth film;
  std::vector<double> releases_s;  ///< when it is let go, once a pluck [s]
  bool nonlinear = false;
};

/// Renders a film of the rig let go from its release: linear modes of a reference mesh, each
/// decaying by eq. (14), held before and free after, once or several times; or, if that is asked
/// for, its nonlinear simulation. The truth's f and d are those of a small motion in both cases.
///
/// @param material  E, nu, rho and b that the part is to have
/// @throws InputError if the rig lacks part, clamp, release, markers or camera; NumericalFailure;
/// Cancelled
[[nodiscard]] RenderTruth render_rig(const Rig& rig,
                                     const ElasticMaterial& material,
                                     const std::filesystem::path& video,
                                     const RenderOptions& options = {});

/// The truth as JSON text, format `twang-truth/1`.
[[nodiscard]] std::string truth_to_json(const Rig& rig, const RenderTruth& truth);

}  // namespace twang
