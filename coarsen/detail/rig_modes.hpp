// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coarsen/identify_moduli.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A mode of a mesh that stands for a measured sinusoid.
struct MeasuredMode {
  std::size_t measurement = 0;
  int number = 0;  ///< of the mesh's modes, from 0
  double lambda_per_s2 = 0.0;
  std::map<std::string, double> energy_shares;  ///< by material, those of unknown modulus [-]
};

/// A rig on one mesh: the modes that were measured, at any moduli of its materials.
class RigModes {
 public:
  RigModes(const Rig& rig, double dx_m) : m_rig(&rig), m_dx_m(dx_m) {}

  [[nodiscard]] const Rig* rig() const { return m_rig; }
  [[nodiscard]] double dx_m() const { return m_dx_m; }
  void add(std::size_t index, const ModalMeasurement& measurement);
  /// @param moduli  of the materials without a stated one [Pa]
  /// @throws InputError if more modes are measured than can be seen; NumericalFailure; Cancelled
  [[nodiscard]] std::vector<MeasuredMode> compute(const std::map<std::string, double>& moduli,
                                                  const ProgressCallback& progress);
  /// Halves the cells, until the mesh is another; false if the mesh would then have more than
  /// `max_dofs` unknowns.
  bool refine(long max_dofs);

 private:
  struct Wanted {
    std::size_t index;
    double frequency_hz;
    std::optional<int> stated;  // mode
  };
  [[nodiscard]] int most_modes() const;
  [[nodiscard]] std::vector<int> assign(const MeshRung& rung) const;

  const Rig* m_rig;
  double m_dx_m;
  std::vector<Wanted> m_wanted;
};

}  // namespace twang
