// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/material.hpp"
#include "tests/support/temporary_folder.hpp"

#include <filesystem>
#include <string>

namespace twang::test {

inline constexpr const char* kStripRig = R"(format = "twang-rig/1"
name = "short strip"
[materials.part]
density_kg_m3 = 1180.0
poissons_ratio = 0.4
[[part]]
material = "part"
shape = "box"
min_mm = [0.0, 0.0, 0.0]
max_mm = [40.0, 10.0, 4.0]
[[clamp]]
min_mm = [0.0, 0.0, 0.0]
max_mm = [0.0, 10.0, 4.0]
[[marker]]
id = "tip"
kind = "dot"
size_mm = 4.0
position_mm = [38.0, 0.0, 2.0]
)";

/// A strip of 8 x 2 x 2 cells, bent and let go after two steps.
inline constexpr const char* kStripScene = R"(format = "twang-scene/1"
duration_s = 4e-3
step_s = 1e-4
gravity_m_s2 = [0.0, 0.0, -9.81]
integrator = "newmark"
[[body]]
name = "strip"
rig = "strip.toml"
dx_mm = 5.0
element = "hex8"
clamped = true
[body.material]
youngs_modulus_pa = 5e7
damping_stiffness_b_s = 1e-4
[[load]]
body = "strip"
at_mm = [40.0, 5.0, 2.0]
displacement_mm = [0.0, 0.0, -4.0]
release_s = 2e-4
[[probe]]
body = "strip"
marker = "tip"
[output]
every_s = 5e-4
vtu = true
checkpoint_every_s = 1e-3
)";

/// A folder with the rig and a scene.
struct SampleScene {
  explicit SampleScene(const std::string& text = kStripScene) {
    folder.write("strip.toml", kStripRig);
    scene = folder.write("scene.toml", text);
  }
  TemporaryFolder folder;
  std::filesystem::path scene;
};

/// `text` with its one `from` replaced.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace twang::test
