// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "simulate/detail/csv_stream.hpp"
#include "simulate/energy_ledger.hpp"
#include "simulate/simulated_body.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace twang::detail {

/// How long the tables were and how many frames there were when a checkpoint was written.
struct FileLengths {
  std::int64_t motion = 0;
  std::int64_t probes = 0;
  std::int64_t energy = 0;
  std::int64_t frames = 0;
};

/// The tables and frames of a run, in one folder.
class SceneFiles {
 public:
  /// @param continue_at  absent: they begin anew
  SceneFiles(const std::filesystem::path& folder,
             const std::vector<SimulatedBody>& bodies,
             bool vtu,
             std::optional<FileLengths> continue_at);

  void add_energy(double time_s, const MechanicalState& now, const EnergyLedger& ledger);
  /// A row of `motion.csv` and `probes.csv`, and a frame.
  void add_frame(double time_s, const std::vector<SimulatedBody>& bodies);
  /// Hands all that was added to the system.
  void flush();
  /// Puts it on the disk, the list of frames included.
  FileLengths sync();

  /// Times of the frames so far [s].
  [[nodiscard]] const std::vector<double>& frame_times() const { return m_frame_times; }
  void set_frame_times(std::vector<double> times) { m_frame_times = std::move(times); }

 private:
  void write_vtu_frame(const SimulatedBody& body, const HexMesh& at_start, std::size_t frame) const;
  void write_pvd() const;

  std::filesystem::path m_folder;
  std::vector<std::string> m_names;
  bool m_vtu;
  CsvStream m_motion;
  CsvStream m_probes;
  CsvStream m_energy;
  std::vector<HexMesh> m_meshes;  // at the starting pose; empty without frames
  std::vector<double> m_frame_times;
};

}  // namespace twang::detail
