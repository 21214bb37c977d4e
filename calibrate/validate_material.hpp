// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/validate.hpp"
#include "core/material.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "fem/hexahedron.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"

#include <optional>
#include <string>

namespace twang {

struct MaterialValidationOptions {
  std::string column;          ///< of the trace; empty: the rig's observable, else the first
  std::optional<double> dx_m;  ///< absent: of the mesh to which E_n belongs [m]
  std::optional<ElementKind> element;  ///< absent: the same
  bool identified = false;             ///< E instead of E_n
  InversionOptions inversion;          ///< window and band
  ProgressCallback progress = {};
  MeshObserver on_state = {};  ///< sees every simulated state; a step that fails begins them anew
};

/// What one number is worth beside its bound.
struct FigureOfMerit {
  std::string name;
  double value = kNaN;  ///< relative [-]
  double bound = 0.0;   ///< of its absolute value [-]
  [[nodiscard]] bool met() const;
};

/// A material held against a tracked motion: simulated from the tracked start, let go and compared.
struct MaterialValidation {
  Validation validation;
  InversionResult inversion;  ///< of the trace
  std::string column;
  int num_elements = 0;
  double dx_m = 0.0;
  ElementKind element = ElementKind::Hex8;
  /// By how much the simulated motion leads at the end of the periods compared, less what it leads
  /// at their beginning [rad].
  double phase_drift_rad = kNaN;

  /// rms, frequency and decay, with their bounds.
  [[nodiscard]] std::vector<FigureOfMerit> figures() const;
};

/// Inverts the trace, puts the rig's mesh where the fitted motion began, lets it go and compares.
/// @throws InputError if E_n belongs to another mesh, the material or the column is not there
/// @throws NumericalFailure if no vibration is found or the mesh cannot follow; Cancelled
[[nodiscard]] MaterialValidation validate_material(const Rig& rig,
                                                   const Material& material,
                                                   const Trace& trace,
                                                   const MaterialValidationOptions& options = {});

/// As JSON text, format `twang-validation/1`.
[[nodiscard]] std::string validation_to_json(const MaterialValidation& validation);

/// How far series `b` leads `a` in phase over the last period, less over the first: of each the
/// phase of the sinusoid that fits best. Where a period has too few samples, more periods are taken
/// for one; not a number if these overlap [rad].
[[nodiscard]] double phase_drift(const std::vector<double>& time_s,
                                 const std::vector<double>& a,
                                 const std::vector<double>& b,
                                 double frequency_hz);

}  // namespace twang
