// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/choose_mode.hpp"
#include "calibrate/refine_material.hpp"
#include "calibrate/validate.hpp"
#include "capture/track_markers.hpp"
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/releases.hpp"
#include "harmonic_inversion/spectrum.hpp"
#include "rigs/rig.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace twang {

struct CalibrationOptions {
  std::vector<std::string> columns;  ///< inverted; empty: the observable if there is one, else all
  std::string time_column = "time_s";           ///< of trace files
  InversionOptions inversion;                   ///< window and band, for every repeat
  TrackOptions track;                           ///< of every film; its `overlay` is not used
  std::vector<std::filesystem::path> overlays;  ///< one a film, or empty: none
  LadderOptions ladder;                         ///< `coarse_dx_m` picks the coarse mesh
  bool validate = true;                         ///< simulate the coarse mesh over the trace
  ProgressCallback progress = {};
  /// Called when a film has been tracked, before the next one begins.
  std::function<void(const std::filesystem::path& film, const TrackResult& result)> on_tracked = {};
  /// Every release in a recording is a repeat of its own, see `cut_at_releases`.
  bool each_release = false;
  /// The eigenmode that the strongest sinusoid is, from 0; absent: chosen, see `choose_mode`.
  std::optional<int> mode = {};
  bool refine = false;  ///< E_n, E and b by the nonlinear simulation, see `refine_material`
};

/// One recording on its way through the line, or one release of it.
struct Repeat {
  std::filesystem::path file;
  /// Absent when it came as a trace, or with a release before of the same film.
  std::optional<TrackResult> film;
  Trace trace;                       ///< of the release alone where a recording holds several
  std::vector<std::string> columns;  ///< those inverted
  InversionResult inversion;
  Spectrum spectrum;  ///< of the first column, in the window used
  /// Of the inversion's model at the same time stamps, with the same window and padding.
  Spectrum model_spectrum;
};

/// Everything a calibration found on its way from film to material.
struct Calibration {
  Material material;
  std::vector<Repeat> repeats;
  InversionResult inversion;   ///< joint over all repeats; with one, that repeat's own
  DampedSinusoid fundamental;  ///< strongest sinusoid, its sigmas widened by window_stability
  DampedTarget target;         ///< of the fundamental
  ModulusSensitivities sensitivities;
  MeshLadder ladder;
  std::optional<Validation> validation;  ///< of the first repeat
  std::vector<std::string> warnings;     ///< what may make it wrong, one sentence each
  std::vector<std::string> remarks;      ///< how it went, one sentence each
  ModeChoice mode;                       ///< that the fundamental is, of the finest reference mesh
  int coarse_mode = 0;                   ///< the same of the coarse mesh, from 0
  RichardsonLimit limit;                 ///< of that mode
  /// If that was asked for; in `material` where usable, else a sentence says why not.
  std::optional<RefinedMaterial> refined;
};

/// The inversion of all repeats with that of each, decay checks and all.
[[nodiscard]] RepeatedInversion inversion_of_repeats(const Calibration& calibration);

/// Film(s) in, a material out: track, invert, walk the mesh ladder, fit, validate.
/// @throws InputError, Cancelled; NumericalFailure if no mode is found or an eigenproblem fails
[[nodiscard]] Calibration calibrate_from_films(const Rig& rig,
                                               const std::vector<std::filesystem::path>& films,
                                               const CalibrationOptions& options = {});

/// The same from traces that are already there.
[[nodiscard]] Calibration calibrate_from_traces(const Rig& rig,
                                                const std::vector<std::filesystem::path>& traces,
                                                const CalibrationOptions& options = {});

}  // namespace twang
