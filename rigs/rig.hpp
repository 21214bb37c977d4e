// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace twang {

/// An axis-aligned box, `min` <= `max` in each coordinate [m].
struct Box {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();

  /// Whether `point` lies in the box widened by `margin` on every side [m].
  [[nodiscard]] bool contains(const Eigen::Vector3d& point, double margin) const;
  /// Distance from `point` to the nearest point of the box; 0 inside [m].
  [[nodiscard]] double distance(const Eigen::Vector3d& point) const;
};

/// A solid cylinder between the centres of its two end faces [m].
struct Cylinder {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  double radius = 0.0;
};

/// A closed surface in a file (STL or OBJ), scaled by `metres_per_unit` and moved by `at`, or in
/// memory [m].
struct SurfaceFile {
  std::filesystem::path file;
  double metres_per_unit = 1e-3;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  std::optional<Box> box;           ///< around the surface, if it has been read [m]
  Eigen::Matrix3Xd vertices = {};   ///< of a surface in memory, whose file is but its name [m]
  Eigen::Matrix3Xi triangles = {};  ///< of it, (3 x triangles); empty: the file is read
};

/// One solid of the union that makes the part; a later one overrides an earlier one's material.
struct PartSolid {
  std::string material;
  std::variant<Box, Cylinder, SurfaceFile> shape;
};

/// What a rig says of a material. The modulus is absent where it is to be identified.
struct RigMaterial {
  std::string name;
  double density_kg_m3 = 0.0;                        ///< rho > 0 [kg/m³]
  double poissons_ratio = 0.0;                       ///< nu, -1 < nu < 0.5 [-]
  std::optional<double> youngs_modulus_pa;           ///< stated: known, not identified [Pa]
  std::optional<double> reported_youngs_modulus_pa;  ///< for the table only [Pa]
};

enum class MarkerKind { Cross, Dot, Ring, Checker, ArUco, AprilTag, Patch };

/// The name a rig file uses for a kind of marker ("cross").
[[nodiscard]] std::string_view to_string(MarkerKind kind);

/// A printed target: on the part, or on the bench (`fixed`).
struct Marker {
  std::string id;
  MarkerKind kind = MarkerKind::Dot;
  double size_m = 0.0;                                 ///< outer size > 0 [m]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< rig frame, at rest [m]
  bool fixed = false;
  std::string dictionary;  ///< of ArUco and AprilTag
  int tag = -1;
};

enum class ObservableKind { Displacement, Angle };

/// The scalar that is inverted and compared.
struct ObservableDefinition {
  ObservableKind kind = ObservableKind::Displacement;
  std::vector<std::string> markers;  ///< displacement: one; angle: a and b of the line a -> b
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of a displacement, any length > 0
};

/// How the part is deflected before it is let go: exactly one of displacement and force.
struct Release {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< [m]
  std::optional<Eigen::Vector3d> displacement;   ///< [m]
  std::optional<Eigen::Vector3d> force;          ///< [N]
};

/// How the rig is filmed.
struct Camera {
  std::optional<double> capture_fps;  ///< what the camera did, whatever the file says [1/s]
  Eigen::Vector3d image_right = Eigen::Vector3d::UnitX();  ///< unit vector, rig frame
  Eigen::Vector3d image_down =
      -Eigen::Vector3d::UnitZ();  ///< unit vector orthogonal to image_right, rig frame
  double readout_s = 0.0;         ///< rolling shutter, first row to last [s]
  std::filesystem::path lens;     ///< calibration of the camera; empty: none
};

/// One sigma of what the rig file states; 0 where nothing is said.
struct Tolerance {
  double dimension_m = 0.0;     ///< of a printed length [m]
  double density_rel = 0.0;     ///< relative [-]
  double poissons_ratio = 0.0;  ///< absolute [-]
  double clock_rel = 0.0;       ///< relative error of the camera's clock [-]
};

/// A weight glued on.
struct PointMass {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< [m]
  double mass_kg = 0.0;                          ///< > 0 [kg]
  Eigen::Vector3d size =
      Eigen::Vector3d::Zero();  ///< of the box around `at` over which it is spread; 0: a point [m]
};

/// What becomes of cells that the part fills in part.
enum class PartialCells {
  None,             ///< a cell is full if its centre lies in the part, else empty
  Mass,             ///< a cell has the mass of what is in it
  MassAndStiffness  ///< and its share of the stiffness
};

/// The name a rig file uses for it ("mass_and_stiffness").
[[nodiscard]] std::string_view to_string(PartialCells partial_cells);
/// @throws InputError for another name
[[nodiscard]] PartialCells partial_cells_from(std::string_view name);

/// A mesh of hexahedra in a file (Gmsh `.msh` or VTK `.vtu`), scaled by `metres_per_unit` and moved
/// by `at` [m].
struct MeshFile {
  std::filesystem::path file;
  double metres_per_unit = 1e-3;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  std::map<std::string, std::string> material_of_group;  ///< by the name or number of the group
};

/// How the part becomes a mesh.
struct Meshing {
  PartialCells partial_cells = PartialCells::None;
  std::optional<MeshFile> file;  ///< then the rig has no solids
};

/// A rig: the part, how it is held, what is on it and how it is filmed; lengths in metres (file
/// format `twang-rig/1`).
struct Rig {
  std::string name;
  std::filesystem::path file;                   ///< where it was read from; empty if made in memory
  std::string sha256;                           ///< of that file
  std::map<std::string, std::string> specimen;  ///< free text
  std::vector<RigMaterial> materials;
  std::vector<PartSolid> parts;
  std::vector<Box> clamps;
  std::vector<Marker> markers;
  std::optional<ObservableDefinition> observable;
  std::optional<Release> release;
  std::optional<Camera> camera;
  Tolerance tolerance;
  std::optional<Eigen::Vector3d> gravity_m_s2;  ///< absent: none
  std::vector<PointMass> masses;
  Meshing meshing;

  [[nodiscard]] const Marker* find_marker(std::string_view id) const;
  [[nodiscard]] const RigMaterial* find_material(std::string_view name) const;
  /// Smallest box around all solids [m]; surface files are read for it.
  /// @throws InputError if there is no solid
  [[nodiscard]] Box bounding_box() const;
};

/// Whether `point` lies in `solid`: lower face included, upper not, for boxes; surfaces are not
/// asked here. [m]
/// @throws InputError for a SurfaceFile
[[nodiscard]] bool contains(const PartSolid& solid, const Eigen::Vector3d& point);

}  // namespace twang
