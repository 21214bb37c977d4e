// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/validate.hpp"
#include "capture/track_markers.hpp"
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/spectrum.hpp"
#include "rigs/rig.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace twang {

struct CalibrationOptions {
  std::optional<double> coarse_dx_m;  ///< the coarse mesh; absent: chosen by the ladder [m]
  std::vector<std::string> columns;   ///< of a trace; empty: its default columns
  std::string time_column = "time_s";
  InversionOptions inversion;  ///< start, end, band
  TrackOptions track;          ///< of every film; `overlay` is set per film by the caller
  LadderOptions ladder;
  bool validate = true;
  ProgressCallback progress = {};
};

/// Everything a calibration found on its way from film to material.
struct Calibration {
  Material material;
  std::vector<TrackResult> films;        ///< one a film; empty from traces
  std::vector<Trace> traces;             ///< one a film or trace file
  InversionResult inversion;             ///< joint over all repeats
  std::vector<InversionResult> repeats;  ///< one a film or trace
  std::vector<Spectrum> spectra;         ///< one a repeat, of the observable used
  MeshLadder ladder;
  std::optional<Validation> validation;
  std::vector<std::string> warnings;  ///< one sentence each
};

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
