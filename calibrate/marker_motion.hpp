// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"

#include <complex>
#include <string>
#include <vector>

namespace twang {

/// How the strongest sinusoid of a signal moves a marker of the part along an axis.
struct MarkerMotion {
  std::string marker;
  int axis = 0;                    ///< 0, 1, 2: x, y, z of the rig frame
  std::complex<double> amplitude;  ///< at the time origin; its angle is the phase [m]
  double sigma_m = 0.0;            ///< one standard deviation of each of its parts [m]
};

/// Of all columns `<marker>.x_mm`, `.y_mm`, `.z_mm` of a trace that belong to moving markers of the
/// rig, by least squares with the sinusoids' frequencies and decays kept:
///
///     y(t) = c0 + c1 t + Re sum_k a_k exp((i 2 pi f_k − d_k) (t − t0))
///
/// @param sinusoids  strongest first
/// @param window     its time origin and end are used
[[nodiscard]] std::vector<MarkerMotion> marker_motion(const Rig& rig,
                                                      const Trace& trace,
                                                      const std::vector<DampedSinusoid>& sinusoids,
                                                      const InversionResult& window);

}  // namespace twang
