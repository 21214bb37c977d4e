// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace twang::test {

/// The contract's example, with every key of the format in use and every value another.
inline constexpr std::string_view kExampleRig = R"(# a rig with everything
format = "twang-rig/1"
name = "strip 80x10x2"
[specimen]
batch = "A7"
printer = "P"
orientation = "flat"
infill = 100
cure = "2 h"
temperature_c = 21.5
printed_on = 2024-03-01
tested_on = "2024-03-04"
note = "first of five"
[materials.part]
density_kg_m3 = 1180.0
poissons_ratio = 0.45
youngs_modulus_pa = 1.9e9
reported_youngs_modulus_pa = 2.1e9
[materials.rubber]
density_kg_m3 = 1070
poissons_ratio = 0.499
[[part]]
material = "part"
shape = "box"
min_mm = [0.0, 0.0, 0.0]
max_mm = [80.0, 10.0, 2.0]
[[part]]
material = "rubber"
shape = "cylinder"
from_mm = [40.0, 5.0, 2.0]
to_mm = [40.0, 5.0, 9.0]
radius_mm = 3.0
[[clamp]]
min_mm = [0.0, 0.0, 0.0]
max_mm = [0.0, 10.0, 2.0]
[[marker]]
id = "tip"
kind = "cross"
size_mm = 5.0
position_mm = [76.0, 0.0, 1.0]
fixed = false
[[marker]]
id = "bench"
kind = "dot"
size_mm = 6.0
position_mm = [7, -30, 12]
fixed = true
[[marker]]
id = "tag"
kind = "aruco"
size_mm = 8.0
position_mm = [60.0, 0.0, 1.5]
dictionary = "4x4_50"
tag = 17
[observable]
kind = "displacement"
marker = "tip"
direction = [0.0, 0.0, 2.0]
[release]
at_mm = [80.0, 5.0, 2.0]
displacement_mm = [0.0, 0.0, -5.0]
[camera]
capture_fps = 240
image_right = [0.0, 3.0, 0.0]
image_down = [0.0, 0.0, -1.0]
readout_ms = 4.0
lens = "phone.yml"
[tolerance]
dimension_mm = 0.085
density_rel = 0.01
poissons_ratio = 0.02
clock_rel = 1e-4
[environment]
gravity_m_s2 = [0.1, 0.2, -9.81]
[[mass]]
at_mm = [70.0, 5.0, 2.0]
mass_g = 1.25
)";

/// kExampleRig with one block of text, which it must hold exactly once, replaced by another; "" if
/// it does not.
inline std::string example_with(std::string_view old_text, std::string_view new_text) {
  std::string text(kExampleRig);
  const std::size_t at = text.find(old_text);
  if (at == std::string::npos || text.find(old_text, at + 1) != std::string::npos) return {};
  return text.replace(at, old_text.size(), new_text);
}

/// Line of `text`, counted from 1, on which `part` begins.
inline int line_of(std::string_view text, std::string_view part) {
  int line = 1;
  for (std::size_t i = 0; i < text.find(part) && i < text.size(); ++i) line += text[i] == '\n';
  return line;
}

}  // namespace twang::test
