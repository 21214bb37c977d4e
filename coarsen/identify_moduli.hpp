// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/damped_sinusoid.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace twang {

/// One damped sinusoid of one rig. Materials of equal names are the same in all rigs.
struct ModalMeasurement {
  const Rig* rig = nullptr;  ///< with part and clamp; several measurements may share one
  DampedSinusoid sinusoid;   ///< what was tracked
  std::optional<int> mode;   ///< of the mesh, ascending from 0; absent: assigned, see below
  std::string name = {};     ///< for messages ("a.json"); empty: the rig's
};

struct IdentifyOptions {
  std::optional<double> dx_m;       ///< of the first mesh; absent: as a ladder starts [m]
  double convergent_change = 0.02;  ///< moduli change by less on halving dx: enough [-]
  long max_dofs = 200'000;          ///< unknowns that a mesh may have
  ProgressCallback progress = {};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// A material that was not known.
struct IdentifiedMaterial {
  std::string name;
  double youngs_modulus_pa = 0.0;            ///< E [Pa]
  double statistical_rel = 0.0;              ///< sigma of ln E from the sinusoids'; infinite where
                                             ///< the data do not tell it [-]
  double mesh_rel = 0.0;                     ///< what the mesh leaves uncertain [-]
  double damping_stiffness_b_s = 0.0;        ///< b [s]
  double damping_stiffness_b_sigma_s = 0.0;  ///< one standard deviation [s]
  /// Root sum of squares of both parts [-].
  [[nodiscard]] double youngs_modulus_sigma_rel() const;
};

/// The moduli of several materials, from the frequencies of several rigs or modes.
struct IdentifiedMaterials {
  std::vector<IdentifiedMaterial> materials;  ///< in the order in which the rigs name them
  /// Which part of a mode's strain energy is each material's, d ln lambda / d ln E,
  /// (measurements x materials) [-].
  Eigen::MatrixXd energy_shares;
  Eigen::VectorXd known_shares;    ///< that of materials with a stated modulus, (measurements) [-]
  std::vector<int> modes;          ///< of the mesh, one a measurement, from 0
  Eigen::VectorXd misfit;          ///< ln of the mesh's lambda over the tracked one [-]
  Eigen::MatrixXd correlation;     ///< of the ln E, (materials x materials)
  double condition_number = 0.0;   ///< of the energy shares
  bool distinguishable = true;     ///< the data tell the materials apart
  std::vector<std::string> notes;  ///< one sentence each
  std::vector<double> dx_m;        ///< of the finest mesh, one a measurement [m]
  int iterations = 0;
};

/// Young's moduli and dampings of all materials without a stated modulus, by least squares on the
/// eigenvalues:
///
///     minimize  sum_k ((ln lambda_k(E) - ln lambda_t,k) / sigma_k)²
///     d ln lambda_k / d ln E_m = phi_k^T K_m phi_k / phi_k^T K phi_k      the share of the energy
///     2 d_k / lambda_k = sum_m share_km b_m
///
/// by Gauss-Newton in ln E on hex20 meshes, which are refined by halving dx until the moduli stand.
/// Sinusoids without a stated mode are the rig's in ascending order: the first n modes of the mesh,
/// at the moduli found, that its observable can see (all, without one). Sinusoids without a sigma
/// are weighed alike.
///
/// Where the shares of two materials are alike in all measurements, frequencies tell only a product
/// of powers of their moduli: `distinguishable` is then false, and a note says which.
/// @throws InputError if there are fewer measurements than unknown materials, or none, or a rig
/// lacks part or clamp; Cancelled; NumericalFailure if an eigenproblem fails or the iteration does
/// not settle
[[nodiscard]] IdentifiedMaterials identify_moduli(const std::vector<ModalMeasurement>& measurements,
                                                  const IdentifyOptions& options = {});

}  // namespace twang
