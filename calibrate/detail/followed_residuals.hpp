// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/refine_material.hpp"
#include "calibrate/trace_follower.hpp"

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <string>

namespace twang::detail {

/// ln E_n and ln (b sqrt E_n) over those of the linear estimate, then ln amplitude and phase of a
/// start: all 0 at the beginning.
constexpr Eigen::Index kNumShared = 2;
constexpr Eigen::Index kNumOwn = 2;
constexpr Eigen::Index kNumParameters = kNumShared + kNumOwn;
using Parameters = Eigen::Matrix<double, kNumParameters, 1>;

/// The samples of a recording that are followed.
struct Samples {
  Eigen::VectorXd time_s;
  Eigen::VectorXd value;   // in the column's unit
  Eigen::VectorXd weight;  // 1 / sigma; 0: left out
  Eigen::MatrixXd
      rest;  // orthonormal: what an offset, and perhaps a drift, adds to weighed samples
  double end_s = 0.0;
  std::string fault;  // why they are too few to be followed; empty: they are not
  [[nodiscard]] Eigen::Index num_used() const { return (weight.array() > 0.0).count(); }
};

/// Of the linear estimate, farther than which no large motion leads it astray [-].
constexpr double kFarthestModulus = 1.5;
constexpr double kFarthestDamping = 4.0;

/// Rows times their weights, less what an offset explains of them.
[[nodiscard]] Eigen::MatrixXd weighed(const Eigen::MatrixXd& rows, const Samples& samples);

/// The simulation beside the samples of a recording: residuals and their derivatives.
class FollowedResiduals {
 public:
  FollowedResiduals(const Rig& rig,
                    const MeshRung& coarse,
                    const Material& material,
                    const RefinedRecording& recording,
                    int mode,
                    const RefineMaterialOptions& options,
                    const std::function<void()>& simulated);

  struct Values {
    Eigen::VectorXd simulated;
    Eigen::VectorXd slope;  // its time derivative
  };

  [[nodiscard]] const Samples& samples() const { return m_samples; }
  [[nodiscard]] const TraceFollower& follower() const { return m_follower; }

  [[nodiscard]] ElasticMaterial material_at(const Parameters& p) const {
    ElasticMaterial elastic = {m_material.youngs_modulus_numerical_pa * std::exp(p[0]),
                               m_material.poissons_ratio,
                               m_material.density_kg_m3,
                               m_material.damping_stiffness_b_s * std::exp(p[1] - 0.5 * p[0]),
                               m_material.damping_mass_a_per_s};
    return elastic;
  }
  [[nodiscard]] static FollowedStart start_at(const Parameters& p) {
    return {std::exp(p[2]), p[3], std::exp(0.5 * p[0])};
  }

  /// Nothing if the simulation fails; the reason is in `message`.
  [[nodiscard]] const Values* values(const Parameters& p);
  /// d simulated / d parameters, one row a sample; nothing if a simulation fails. Differences of
  /// simulations where the parameters have gone far, else Broyden's updates from those that were
  /// made anyway.
  [[nodiscard]] std::optional<Eigen::MatrixXd> derivatives(const Parameters& p);

  [[nodiscard]] const std::string& message() const { return m_message; }

  /// Takes samples far off the simulation at `p` out of what is followed.
  /// @return how many
  int leave_out_outliers(const Parameters& p);

 private:
  [[nodiscard]] std::optional<Values> simulate(const Parameters& p);
  /// Of the values: d simulated / d ln E_n where the motion is dilated in time.
  [[nodiscard]] Eigen::VectorXd dilation() const;
  bool difference(const Parameters& p);
  void update(const Parameters& p);

  const Material& m_material;
  const RefineMaterialOptions& m_options;
  Samples m_samples;
  TraceFollower m_follower;
  bool m_dilates;
  bool m_drifts;
  double m_origin_s;
  std::function<void()> m_simulated;
  std::optional<Values> m_values;
  Parameters m_at = Parameters::Zero();
  Eigen::MatrixXd m_columns;
  Parameters m_columns_at = Parameters::Zero();
  Parameters m_differenced_at = Parameters::Zero();
  Eigen::VectorXd m_simulated_there;
  std::string m_message;
};

}  // namespace twang::detail
