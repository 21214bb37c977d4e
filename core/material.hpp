// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace twang {

/// What an elastic, Rayleigh-damped solid needs to move: the values a simulation reads.
struct ElasticMaterial {
  double youngs_modulus_pa = 1.0;      ///< E [Pa]
  double poissons_ratio = 0.0;         ///< nu, -1 < nu < 0.5 [-]
  double density_kg_m3 = 1.0;          ///< rho [kg/m³]
  double damping_stiffness_b_s = 0.0;  ///< b in D = a M + b K [s]
  double damping_mass_a_per_s = 0.0;   ///< a in D = a M + b K [1/s]
};

/// Relative parts of the standard deviation of the identified Young's modulus; absent contributions
/// are 0 [-].
struct UncertaintyBudget {
  double statistical = 0.0;
  double repeats = 0.0;
  double mesh = 0.0;
  double clock = 0.0;
  double dimension = 0.0;
  double density = 0.0;
  double poissons_ratio = 0.0;

  /// Root sum of squares of all parts [-].
  [[nodiscard]] double total() const;
};

/// How well the simulation of the coarse mesh follows the tracked observable.
struct ValidationFigures {
  double rms_rel = kNaN;  ///< rms difference over the first ten periods / initial amplitude [-]
  double frequency_error_rel = kNaN;  ///< simulated over tracked frequency, minus one [-]
  double decay_error_rel = kNaN;      ///< simulated over tracked decay, minus one [-]
};

/// What following the trace with the nonlinear simulation changed in a linear estimate.
struct Refinement {
  double linear_youngs_modulus_numerical_pa = kNaN;  ///< E_n before [Pa]
  double linear_damping_stiffness_b_s = kNaN;        ///< b before [s]
  double modulus_change_rel = kNaN;                  ///< of E_n and E, over that before [-]
  double modulus_sigma_rel = kNaN;                   ///< one sigma of E_n by this fit, over E_n [-]
  double damping_change_rel = kNaN;                  ///< of b [-]
  double damping_sigma_rel = kNaN;                   ///< one sigma of b by this fit, over b [-]
  double periods = kNaN;                             ///< of the motion followed, of each recording
  double amplitude = kNaN;            ///< the largest at a start, in the observable's unit
  double residual_rel = kNaN;         ///< rms difference left, over the amplitude [-]
  double linear_residual_rel = kNaN;  ///< rms difference before [-]
  int samples = 0;
  int simulations = 0;
};

/// An input of a result, named and fingerprinted.
struct ProvenanceInput {
  std::string file;
  std::string sha256;
};

/// Where a result comes from.
struct Provenance {
  std::string twang_version;
  std::vector<ProvenanceInput> inputs;
  std::map<std::string, std::string> options;  ///< as used
  std::string date;                            ///< ISO 8601, UTC
};

/// A row of the material table: what a calibration found, with where and how (file format
/// `twang-material/1`).
struct Material {
  std::string material;                              ///< its name in the rig
  double youngs_modulus_identified_pa = kNaN;        ///< E of the mesh limit [Pa]
  double youngs_modulus_identified_sigma_pa = kNaN;  ///< one standard deviation [Pa]
  double youngs_modulus_numerical_pa = kNaN;         ///< E_n, belongs to the mesh named below [Pa]
  std::string numerical_element;                     ///< "hex8"
  double numerical_dx_mm = kNaN;                     ///< requested cell size of that mesh [mm]
  int numerical_elements = 0;                        ///< its number of elements
  std::string rig_sha256;
  double damping_stiffness_b_s = kNaN;        ///< b [s]
  double damping_stiffness_b_sigma_s = kNaN;  ///< one standard deviation [s]
  double damping_mass_a_per_s = 0.0;          ///< a [1/s]
  double poissons_ratio = kNaN;               ///< nu [-]
  double density_kg_m3 = kNaN;                ///< rho [kg/m³]
  std::optional<double>
      reported_youngs_modulus_pa;  ///< what the maker says, for the table only [Pa]
  double frequency_hz = kNaN;
  double frequency_sigma_hz = kNaN;
  double decay_per_s = kNaN;
  double decay_sigma_per_s = kNaN;
  double lambda_per_s2 = kNaN;
  double tan_delta = kNaN;  ///< loss factor at frequency_hz, b sqrt(lambda) [-]
  std::array<double, 2> amplitude_range = {
      kNaN, kNaN};  ///< smallest and largest amplitude of the observable used, in amplitude_unit
  std::string amplitude_unit;  ///< "mm" or "rad"
  UncertaintyBudget uncertainty;
  ValidationFigures validation;
  std::map<std::string, std::string> specimen;  ///< free text carried over from the rig
  Provenance provenance;
  int eigenmode = 1;                     ///< of the mesh that was tracked, from 1
  std::string eigenmode_reason;          ///< why that one, one sentence; may be empty
  std::optional<Refinement> refinement;  ///< if E, E_n and b are not the linear estimate's
};

}  // namespace twang
