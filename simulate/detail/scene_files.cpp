// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/scene_files.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fem/vtu.hpp"
#include "simulate/detail/cell_stress.hpp"

#include <fmt/format.h>

#include <array>
#include <system_error>

namespace twang::detail {
namespace {

std::string motion_header(const std::vector<SimulatedBody>& bodies) {
  std::string header = "time_s";
  for (const SimulatedBody& body : bodies)
    for (const char* column :
         {"x_mm", "y_mm", "z_mm", "vx_m_s", "vy_m_s", "vz_m_s", "qw", "qx", "qy", "qz"})
      header += fmt::format(",{}.{}", body.name(), column);
  return header;
}

std::string probes_header(const std::vector<SimulatedBody>& bodies) {
  std::string header = "time_s";
  for (const SimulatedBody& body : bodies)
    for (const std::string& marker : body.probe_names())
      for (const char* axis : {"x", "y", "z"})
        header += fmt::format(",{}.{}.{}_mm", body.name(), marker, axis);
  return header;
}

constexpr const char* kEnergyHeader =
    "time_s,kinetic_j,elastic_j,gravity_j,external_work_j,damping_j,friction_j,impact_j,"
    "remainder_j,px_kg_m_s,py_kg_m_s,pz_kg_m_s,lx_kg_m2_s,ly_kg_m2_s,lz_kg_m2_s";

std::optional<std::int64_t> part_of(const std::optional<FileLengths>& lengths,
                                    std::int64_t FileLengths::*table) {
  if (!lengths) return std::nullopt;
  return (*lengths).*table;
}

std::string frame_name(const std::string& body, std::size_t frame) {
  return fmt::format("frames/{}_{:06}.vtu", body, frame);
}

}  // namespace

SceneFiles::SceneFiles(const std::filesystem::path& folder,
                       const std::vector<SimulatedBody>& bodies,
                       bool vtu,
                       std::optional<FileLengths> continue_at)
    : m_folder(folder),
      m_vtu(vtu),
      m_motion(
          folder / "motion.csv", motion_header(bodies), part_of(continue_at, &FileLengths::motion)),
      m_probes(
          folder / "probes.csv", probes_header(bodies), part_of(continue_at, &FileLengths::probes)),
      m_energy(folder / "energy.csv", kEnergyHeader, part_of(continue_at, &FileLengths::energy)) {
  for (const SimulatedBody& body : bodies) m_names.push_back(body.name());
  if (!vtu) return;
  std::error_code error;
  std::filesystem::create_directories(folder / "frames", error);
  if (error)
    throw InputError(
        fmt::format("{}: cannot be made: {}", (folder / "frames").string(), error.message()));
  for (const SimulatedBody& body : bodies) {
    m_meshes.push_back(body.body().mesh());
    m_meshes.back().nodes = body.nodes_at_start();
  }
}

void SceneFiles::add_energy(double time_s, const MechanicalState& now, const EnergyLedger& ledger) {
  const LedgerWork& work = ledger.work();
  const std::array<double, 15> row = {time_s,
                                      now.kinetic_j,
                                      now.elastic_j,
                                      now.gravity_j,
                                      work.external_j,
                                      work.damping_j,
                                      work.friction_j,
                                      work.impact_j,
                                      ledger.remainder_j(now),
                                      now.linear.x(),
                                      now.linear.y(),
                                      now.linear.z(),
                                      now.angular.x(),
                                      now.angular.y(),
                                      now.angular.z()};
  m_energy.add(row);
}

void SceneFiles::add_frame(double time_s, const std::vector<SimulatedBody>& bodies) {
  std::vector<double> motion = {time_s};
  std::vector<double> probes = {time_s};
  const auto append = [](std::vector<double>& row, const Eigen::Vector3d& v, double factor) {
    for (int i = 0; i < 3; ++i) row.push_back(factor * v[i]);
  };
  for (const SimulatedBody& body : bodies) {
    const BodyMotion now = body.motion();
    append(motion, now.centre, kMillimetresPerMetre);
    append(motion, now.velocity_m_s, 1.0);
    motion.push_back(now.rotation.w());
    append(motion, now.rotation.vec(), 1.0);
    for (std::size_t i = 0; i < body.probe_names().size(); ++i)
      append(probes, body.probe(i), kMillimetresPerMetre);
  }
  m_motion.add(motion);
  m_probes.add(probes);
  if (m_vtu)
    for (std::size_t i = 0; i < bodies.size(); ++i)
      write_vtu_frame(bodies[i], m_meshes[i], m_frame_times.size());
  m_frame_times.push_back(time_s);
}

void SceneFiles::write_vtu_frame(const SimulatedBody& body,
                                 const HexMesh& at_start,
                                 std::size_t frame) const {
  const Eigen::MatrixXd stress = cell_stress(body.body(), body.state().u, body.rotation());
  write_vtu(m_folder / frame_name(body.name(), frame),
            at_start,
            {{"displacement_m", body.in_world(body.state().u)},
             {"velocity_m_s", body.in_world(body.state().v)}},
            {{"stress_pa", 6, Eigen::Map<const Eigen::VectorXd>(stress.data(), stress.size())},
             {"von_mises_pa", 1, von_mises(stress)}});
}

/// ParaView's list of frames and their times.
void SceneFiles::write_pvd() const {
  std::string xml =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (std::size_t frame = 0; frame < m_frame_times.size(); ++frame)
    for (std::size_t i = 0; i < m_names.size(); ++i)
      xml += fmt::format("    <DataSet timestep=\"{}\" part=\"{}\" name=\"{}\" file=\"{}\"/>\n",
                         exact_text(m_frame_times[frame]),
                         i,
                         escape_xml(m_names[i]),
                         escape_xml(frame_name(m_names[i], frame)));
  xml += "  </Collection>\n</VTKFile>\n";
  write_file_atomically(m_folder / "frames.pvd", xml);
}

void SceneFiles::flush() {
  m_motion.flush();
  m_probes.flush();
  m_energy.flush();
}

FileLengths SceneFiles::sync() {
  FileLengths lengths;
  lengths.motion = m_motion.sync();
  lengths.probes = m_probes.sync();
  lengths.energy = m_energy.sync();
  lengths.frames = static_cast<std::int64_t>(m_frame_times.size());
  if (m_vtu) write_pvd();
  return lengths;
}

}  // namespace twang::detail
