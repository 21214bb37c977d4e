// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/refine_material.hpp"
#include "coarsen/fit_material.hpp"
#include "rigs/load_rig.hpp"

#include <cmath>
#include <string>

namespace twang::test {

constexpr double kCell_m = 3e-3;

/// The L-rig with a leg of two cells and two cells deep: as much bent, in a hundred elements.
inline Rig small_l_rig() {
  return parse_rig(R"(format = "twang-rig/1"
name = "small L-rig"
[materials.part]
density_kg_m3 = 1205.0
poissons_ratio = 0.4
[[part]]
material = "part"
shape = "box"
min_mm = [45.0, 0.0, 0.0]
max_mm = [48.0, 12.0, 18.0]
[[part]]
material = "part"
shape = "box"
min_mm = [9.0, 0.0, 18.0]
max_mm = [48.0, 12.0, 24.0]
[[clamp]]
min_mm = [45.0, 0.0, 0.0]
max_mm = [48.0, 12.0, 0.0]
[[marker]]
id = "left"
kind = "cross"
size_mm = 5.0
position_mm = [12.0, 0.0, 21.0]
[[marker]]
id = "right"
kind = "cross"
size_mm = 5.0
position_mm = [42.0, 0.0, 21.0]
[observable]
kind = "angle"
markers = ["left", "right"]
[release]
at_mm = [9.0, 6.0, 24.0]
displacement_mm = [0.0, 0.0, -20.0]
[camera]
capture_fps = 240
)",
                   "small_lrig.toml");
}

inline Material linear_estimate(const Rig& rig,
                                const MeshRung& rung,
                                const InversionResult& inversion) {
  const DampedTarget target = damped_target(inversion.modes.front());
  Material material;
  material.youngs_modulus_numerical_pa = target.lambda_per_s2 / rung.modes.lambda_per_s2[0];
  material.damping_stiffness_b_s = target.damping_stiffness_b_s;
  material.poissons_ratio = rig.materials.front().poissons_ratio;
  material.density_kg_m3 = rig.materials.front().density_kg_m3;
  return material;
}

/// A decaying sinusoid and its inversion.
struct SwingingRig {
  Trace trace;
  InversionResult inversion;

  explicit SwingingRig(double duration_s, double amplitude_rad = 0.1) {
    trace.channels.push_back({"observable_rad", {}});
    for (int n = 0; n / 240.0 < duration_s; ++n) {
      const double t = n / 240.0;
      trace.time_s.push_back(t);
      trace.channels[0].values.push_back(amplitude_rad * std::exp(-5.0 * t) *
                                         std::cos(kTwoPi * 20.0 * t));
    }
    InversionOptions window;
    window.start_s = 0.0;
    inversion = invert_harmonics(trace, {"observable_rad"}, window);
  }
};

/// Half as many steps do where nothing is bent far.
inline RefineMaterialOptions quick() {
  RefineMaterialOptions options;
  options.steps_per_period = 40.0;
  return options;
}

}  // namespace twang::test
