// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/material.hpp"
#include "fem/constitutive.hpp"
#include "fem/hexahedron.hpp"
#include "rigs/rig.hpp"
#include "simulate/integrators.hpp"

#include <Eigen/Core>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace twang {

/// A calibrated material, as a scene names it.
struct SceneMaterialFile {
  std::filesystem::path path;
  Material material;
  bool identified = false;  ///< E instead of E_n
  std::string key;          ///< "scene.toml:12: body.1.material", for complaints
};

/// A part in a scene: a rig's, meshed.
struct SceneBody {
  std::string name;
  Rig rig;
  double dx_m = 0.0;  ///< requested [m]
  ElementKind element = ElementKind::Hex8;
  ConstitutiveModel model = ConstitutiveModel::NeoHookean;
  std::optional<SceneMaterialFile> material_file;          ///< of all of the part
  std::map<std::string, ElasticMaterial> materials;        ///< by the rig's names; without a file
  bool clamped = true;                                     ///< held where the rig's clamps are
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< of the rig's origin [m]
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< world from rig
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< of the centre of mass
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();    ///< about the centre of mass, world
  std::string key;                                         ///< "scene.toml:7: body.1"
  /// Of linear equations; Automatic: a factor as long as it can be held, else multigrid.
  StiffnessSolverKind solver = StiffnessSolverKind::Automatic;
};

/// A press or pull, in the frame of the body's rig: exactly one of displacement and force. It is
/// there at t = 0, in equilibrium, or grows smoothly from there; what is displaced is held where
/// it is along that direction until the release.
struct SceneLoad {
  std::size_t body = 0;                          ///< index
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< [m]
  std::optional<Eigen::Vector3d> displacement;   ///< [m]
  std::optional<Eigen::Vector3d> force;          ///< [N]
  double release_s = 0.0;                        ///< [s]
  std::string key;                               ///< "scene.toml:30: load.1"
  double ramp_s = 0.0;                           ///< in which it grows from t = 0; 0: there [s]
};

/// A point whose path is written.
struct SceneProbe {
  std::size_t body = 0;
  std::string marker;
};

/// A clamp that moves: how far the world has carried the held nodes since t = 0.
struct SceneBaseMotion {
  std::size_t body = 0;
  std::vector<double> time_s;     ///< increasing, from 0 or below [s]
  Eigen::Matrix3Xd displacement;  ///< (3 x samples), world [m]
};

struct SceneOutput {
  std::optional<double> every_s;  ///< absent: every step [s]
  bool vtu = false;
  std::optional<double> checkpoint_every_s;  ///< absent: none but when interrupted [s]
};

/// What is to be simulated (file format `twang-scene/1`).
struct Scene {
  std::filesystem::path file;
  std::string sha256;  ///< of all that was read: scene, rigs, materials, traces
  double duration_s = 0.0;
  double step_s = 0.0;
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  Scheme scheme = Scheme::Newmark;
  std::vector<SceneBody> bodies;
  std::vector<SceneLoad> loads;
  std::vector<SceneProbe> probes;
  std::vector<SceneBaseMotion> base_motions;  ///< at most one a body
  SceneOutput output;
};

/// Reads a scene file (TOML, format `twang-scene/1`) and all that it names, relative to it.
///
/// Every key is checked as those of a rig file are: an unknown one is an error that names file,
/// line and the nearest known key.
///
/// @throws InputError "FILE:LINE: KEY is VALUE, must be ..." for a file that cannot be read or
/// parsed, an unknown key, a value of the wrong type or out of range, a missing key, a name used
/// twice or never defined
[[nodiscard]] Scene load_scene(const std::filesystem::path& path);

/// The same from the text of a file.
/// @param file  its name, for messages, and the place to which what it names is relative
[[nodiscard]] Scene parse_scene(const std::string& content, const std::filesystem::path& file);

}  // namespace twang
