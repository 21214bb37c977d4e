// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/identify_moduli.hpp"

#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "coarsen/detail/rig_modes.hpp"
#include "coarsen/detail/weighted_solution.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace twang {
namespace {

constexpr int kMostIterations = 40;
constexpr double kSettled = 1e-7;        // last step of ln E
constexpr double kAlmostSettled = 1e-4;  // the same, where no step makes the misfit smaller
constexpr int kMostHalvings = 8;
constexpr double kLargestStep = 1.6;        // of ln E: a factor of five
constexpr double kUntold = 1e-4;            // of a modulus: its sigma is then infinite
constexpr double kLargestCondition = 30.0;  // up to which materials are told apart
constexpr double kLeastShare = 0.02;        // of the energy, below which a material is not seen
constexpr double kMisfit = 0.02;            // of lambda, from which it is worth a sentence
constexpr double kMisfitSigmas = 4.0;       // and beyond the sinusoid's own
constexpr double kFirstGuess_pa = 1e6;
constexpr double kRichardson = 1.0 / 3.0;  // of the last change, at order 2, is what is left

bool known_sigma(double sigma) { return std::isfinite(sigma) && sigma > 0.0; }

class ModulusSearch {
 public:
  ModulusSearch(const std::vector<ModalMeasurement>& measurements, const IdentifyOptions& options)
      : m_measurements(measurements), m_options(options) {}

  IdentifiedMaterials run();

 private:
  void check() const;
  void gather_materials();
  void gather_targets();
  void start();
  void settle(bool first_mesh);
  [[nodiscard]] double weighted_misfit() const {
    return m_weight.cwiseProduct(m_result.misfit).norm();
  }
  void evaluate();
  bool refine();
  void find_damping();
  void note_misfits();
  void judge();
  [[nodiscard]] Eigen::Index num_measurements() const {
    return static_cast<Eigen::Index>(m_measurements.size());
  }

  const std::vector<ModalMeasurement>& m_measurements;
  const IdentifyOptions& m_options;
  IdentifiedMaterials m_result;
  std::vector<RigModes> m_rigs;
  Eigen::VectorXd m_log_target;  // ln lambda
  Eigen::VectorXd m_weight;      // 1 / sigma of it
  bool m_sigmas_known = true;
  bool m_any_known = false;  // a material with a stated modulus
  Eigen::VectorXd m_log_modulus;
  WeightedSolution m_last;
};

void ModulusSearch::check() const {
  m_options.check();
  if (m_measurements.empty()) throw InputError("there is no measured mode, must be one or more");
  for (const ModalMeasurement& measurement : m_measurements) {
    const Rig& rig = *measurement.rig;
    if (rig.parts.empty() || rig.clamps.empty()) {
      throw InputError(fmt::format("rig \"{}\" has no {}, must have part and clamp",
                                   rig.name,
                                   rig.parts.empty() ? "part" : "clamp"));
    }
  }
}

/// The materials of the parts, those without a stated modulus.
void ModulusSearch::gather_materials() {
  for (const ModalMeasurement& measurement : m_measurements) {
    const Rig& rig = *measurement.rig;
    for (const RigMaterial& material : rig.materials) {
      const bool used = std::any_of(rig.parts.begin(), rig.parts.end(), [&](const PartSolid& s) {
        return s.material == material.name;
      });
      if (!used) continue;
      if (material.youngs_modulus_pa) {
        m_any_known = true;
        continue;
      }
      const bool listed = std::any_of(
          m_result.materials.begin(), m_result.materials.end(), [&](const IdentifiedMaterial& m) {
            return m.name == material.name;
          });
      if (!listed) m_result.materials.push_back({material.name});
    }
  }
  if (m_result.materials.empty()) {
    throw InputError(
        "every material states its youngs_modulus_pa, one or more must be left to be identified");
  }
  if (m_result.materials.size() > m_measurements.size()) {
    throw InputError(fmt::format(
        "{} materials have no stated modulus and {} measured, must be as "
        "many modes or more",
        m_result.materials.size(),
        m_measurements.size() == 1 ? "1 mode is"
                                   : fmt::format("{} modes are", m_measurements.size())));
  }
}

void ModulusSearch::gather_targets() {
  m_log_target.resize(num_measurements());
  m_weight.resize(num_measurements());
  for (Eigen::Index k = 0; k < num_measurements(); ++k) {
    const DampedSinusoid& sinusoid = m_measurements[static_cast<std::size_t>(k)].sinusoid;
    m_log_target[k] = std::log(sinusoid.lambda_per_s2());
    const double sigma = sinusoid.lambda_sigma_per_s2() / sinusoid.lambda_per_s2();
    m_sigmas_known = m_sigmas_known && known_sigma(sigma);
    m_weight[k] = 1.0 / sigma;
  }
  if (!m_sigmas_known) m_weight.setOnes();
}

/// The rigs on their first meshes, and moduli to start from.
void ModulusSearch::start() {
  m_log_modulus.resize(static_cast<Eigen::Index>(m_result.materials.size()));
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < m_measurements.size(); ++k) {
    const Rig* rig = m_measurements[k].rig;
    for (const RigMaterial& material : rig->materials) {
      if (!material.youngs_modulus_pa) continue;
      sum += std::log(*material.youngs_modulus_pa);
      count += 1.0;
    }
    auto known = std::find_if(
        m_rigs.begin(), m_rigs.end(), [&](const RigModes& modes) { return modes.rig() == rig; });
    if (known == m_rigs.end()) {
      LadderOptions ladder;
      ladder.start_dx_m = m_options.dx_m;
      ladder.max_dofs = m_options.max_dofs;
      m_rigs.emplace_back(*rig, starting_dx(*rig, ladder, m_result.notes));
      known = m_rigs.end() - 1;
    }
    known->add(k, m_measurements[k]);
  }
  m_log_modulus.setConstant(count > 0.0 ? sum / count : std::log(kFirstGuess_pa));
  for (std::size_t m = 0; m < m_result.materials.size(); ++m) {
    for (const ModalMeasurement& measurement : m_measurements) {
      const RigMaterial* material = measurement.rig->find_material(m_result.materials[m].name);
      if (material == nullptr || !material->reported_youngs_modulus_pa) continue;
      m_log_modulus[static_cast<Eigen::Index>(m)] = std::log(*material->reported_youngs_modulus_pa);
    }
  }
}

/// Eigenvalues and energy shares at the present moduli.
void ModulusSearch::evaluate() {
  const auto num_materials = static_cast<Eigen::Index>(m_result.materials.size());
  m_result.energy_shares.resize(num_measurements(), num_materials);
  m_result.misfit.resize(num_measurements());
  m_result.modes.resize(m_measurements.size());
  m_result.dx_m.resize(m_measurements.size());
  std::map<std::string, double> moduli;
  for (std::size_t m = 0; m < m_result.materials.size(); ++m) {
    moduli[m_result.materials[m].name] = std::exp(m_log_modulus[static_cast<Eigen::Index>(m)]);
  }
  for (RigModes& rig : m_rigs) {
    for (const MeasuredMode& mode : rig.compute(moduli, m_options.progress)) {
      const auto k = static_cast<Eigen::Index>(mode.measurement);
      m_result.misfit[k] = std::log(mode.lambda_per_s2) - m_log_target[k];
      m_result.modes[mode.measurement] = mode.number;
      m_result.dx_m[mode.measurement] = rig.dx_m();
      for (Eigen::Index m = 0; m < num_materials; ++m) {
        const auto share =
            mode.energy_shares.find(m_result.materials[static_cast<std::size_t>(m)].name);
        m_result.energy_shares(k, m) = share == mode.energy_shares.end() ? 0.0 : share->second;
      }
    }
  }
  m_result.known_shares =
      Eigen::VectorXd::Ones(num_measurements()) - m_result.energy_shares.rowwise().sum();
}

/// Gauss-Newton, a step halved as long as it makes the misfit larger.
void ModulusSearch::settle(bool first_mesh) {
  evaluate();
  if (first_mesh && !m_any_known) {
    // All moduli times a factor are all eigenvalues times it, whatever the shapes.
    const double scale = -m_result.misfit.mean();
    m_log_modulus.array() += scale;
    m_result.misfit.array() += scale;
  }
  for (int i = 0; i < kMostIterations; ++i) {
    ++m_result.iterations;
    m_last = solve_weighted(m_result.energy_shares, -m_result.misfit, m_weight);
    const double longest = m_last.x.cwiseAbs().maxCoeff();
    if (longest < kSettled) return;
    const Eigen::VectorXd from = m_log_modulus;
    const double before = weighted_misfit();
    Eigen::VectorXd step = std::min(1.0, kLargestStep / longest) * m_last.x;
    for (int halving = 0; halving <= kMostHalvings; ++halving, step *= 0.5) {
      m_log_modulus = from + step;
      evaluate();
      if (weighted_misfit() < before) break;
    }
    // What rounding leaves of a misfit grows and shrinks by chance.
    if (!(weighted_misfit() < before)) {
      if (longest < kAlmostSettled) return;
      throw NumericalFailure(
          "no set of moduli explains all measured modes: the search does not get on; are they the "
          "mesh's modes that they are taken for?");
    }
  }
  throw NumericalFailure(fmt::format(
      "the moduli do not settle in {} iterations: no set of moduli explains all measured modes",
      kMostIterations));
}

/// Halves the cells of every rig that has room; false if none has.
bool ModulusSearch::refine() {
  bool refined = false;
  for (RigModes& rig : m_rigs) refined = rig.refine(m_options.max_dofs) || refined;
  return refined;
}

/// 2 d / lambda = sum over materials of share b.
void ModulusSearch::find_damping() {
  Eigen::VectorXd b(num_measurements());
  Eigen::VectorXd weight(num_measurements());
  bool sigmas_known = true;
  for (Eigen::Index k = 0; k < num_measurements(); ++k) {
    const DampedSinusoid& sinusoid = m_measurements[static_cast<std::size_t>(k)].sinusoid;
    b[k] = sinusoid.damping_stiffness_b_s();
    const double sigma = sinusoid.damping_stiffness_b_sigma_s();
    sigmas_known = sigmas_known && known_sigma(sigma);
    weight[k] = 1.0 / sigma;
  }
  if (!sigmas_known) weight.setOnes();
  const WeightedSolution found = solve_weighted(m_result.energy_shares, b, weight);
  for (std::size_t m = 0; m < m_result.materials.size(); ++m) {
    const auto i = static_cast<Eigen::Index>(m);
    IdentifiedMaterial& material = m_result.materials[m];
    material.damping_stiffness_b_s = found.x[i];
    material.damping_stiffness_b_sigma_s = sigmas_known ? std::sqrt(found.covariance(i, i)) : kNaN;
    if (found.x[i] < 0.0) {
      m_result.notes.push_back(fmt::format(
          "the damping of \"{}\" comes out negative: the modes' decays do not follow from one b "
          "each, or hardly depend on it",
          material.name));
    }
  }
  if (m_any_known && m_result.known_shares.maxCoeff() > kLeastShare) {
    m_result.notes.push_back(
        "materials of stated modulus are taken as undamped: what they damp is laid to the others");
  }
}

/// A sentence for each mode that the moduli do not explain.
void ModulusSearch::note_misfits() {
  for (Eigen::Index k = 0; k < num_measurements(); ++k) {
    const double misfit = m_result.misfit[k];
    const bool beyond_noise = !m_sigmas_known || std::abs(misfit) * m_weight[k] > kMisfitSigmas;
    if (std::abs(misfit) < kMisfit || !beyond_noise) continue;
    const ModalMeasurement& measurement = m_measurements[static_cast<std::size_t>(k)];
    m_result.notes.push_back(fmt::format(
        "{}: {:.4g} Hz misses mode {} of the mesh by {:.2g} %: it may be another mode, or the rig "
        "another than described",
        measurement.name.empty() ? measurement.rig->name : measurement.name,
        measurement.sinusoid.natural_frequency_hz(),
        m_result.modes[static_cast<std::size_t>(k)] + 1,
        50.0 * std::abs(misfit)));
  }
}

/// Whether the data tell the materials apart, and a sentence if not.
void ModulusSearch::judge() {
  const Eigen::Index n = m_result.energy_shares.cols();
  m_result.condition_number =
      solve_weighted(
          m_result.energy_shares, m_result.misfit, Eigen::VectorXd::Ones(num_measurements()))
          .condition;
  m_result.distinguishable = m_result.condition_number <= kLargestCondition;
  m_result.correlation = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const double scale = std::sqrt(m_last.covariance(i, i) * m_last.covariance(j, j));
      if (i != j) m_result.correlation(i, j) = scale > 0.0 ? m_last.covariance(i, j) / scale : 0.0;
    }
  }
  if (m_result.distinguishable) return;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double most = m_result.energy_shares.col(i).maxCoeff();
    if (most >= kLeastShare) continue;
    m_result.notes.push_back(fmt::format(
        "\"{}\" holds at most {:.2g} % of the strain energy of any measured mode: the data do not "
        "tell its modulus; a rig or a mode that bends it must be added",
        m_result.materials[static_cast<std::size_t>(i)].name,
        100.0 * most));
    return;
  }
  Eigen::Index a = 0;
  Eigen::Index b = 1;
  double alike = -1.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i + 1; j < n; ++j) {
      const double cosine = m_result.energy_shares.col(i).normalized().dot(
          m_result.energy_shares.col(j).normalized());
      if (cosine > alike) alike = cosine, a = i, b = j;
    }
  }
  m_result.notes.push_back(fmt::format(
      "the data do not tell \"{}\" from \"{}\": their parts of the strain energy keep about one "
      "ratio in all measured modes (condition number {:.3g}); a rig or a mode with another ratio "
      "must be added",
      m_result.materials[static_cast<std::size_t>(a)].name,
      m_result.materials[static_cast<std::size_t>(b)].name,
      m_result.condition_number));
}

IdentifiedMaterials ModulusSearch::run() {
  check();
  gather_materials();
  gather_targets();
  start();
  settle(true);
  Eigen::VectorXd change = Eigen::VectorXd::Constant(m_log_modulus.size(), kNaN);
  while (refine()) {
    const Eigen::VectorXd before = m_log_modulus;
    settle(false);
    change = (m_log_modulus - before).cwiseAbs();
    if (change.maxCoeff() < m_options.convergent_change) break;
  }
  if (!(change.maxCoeff() < m_options.convergent_change)) {
    m_result.notes.push_back(
        fmt::format("the meshes are not convergent: finer ones have more than {} unknowns",
                    m_options.max_dofs));
  }
  const bool overdetermined = m_measurements.size() > m_result.materials.size();
  const double variance =
      m_sigmas_known   ? 1.0
      : overdetermined ? m_result.misfit.squaredNorm() /
                             static_cast<double>(m_measurements.size() - m_result.materials.size())
                       : kNaN;
  for (std::size_t m = 0; m < m_result.materials.size(); ++m) {
    const auto i = static_cast<Eigen::Index>(m);
    m_result.materials[m].youngs_modulus_pa = std::exp(m_log_modulus[i]);
    m_result.materials[m].statistical_rel =
        m_last.untold[i] > kUntold ? kInfinity : std::sqrt(variance * m_last.covariance(i, i));
    m_result.materials[m].mesh_rel = kRichardson * change[i];
  }
  find_damping();
  note_misfits();
  judge();
  return std::move(m_result);
}

}  // namespace

double IdentifiedMaterial::youngs_modulus_sigma_rel() const {
  return std::hypot(statistical_rel, mesh_rel);
}

void IdentifyOptions::check() const {
  if (dx_m && !(*dx_m > 0.0 && std::isfinite(*dx_m))) {
    throw InputError(fmt::format("dx_m is {}, must be > 0", *dx_m));
  }
  if (!(convergent_change > 0.0 && convergent_change < 1.0)) {
    throw InputError(
        fmt::format("convergent_change is {}, must be > 0 and < 1", convergent_change));
  }
  if (max_dofs < 1) throw InputError(fmt::format("max_dofs is {}, must be >= 1", max_dofs));
}

IdentifiedMaterials identify_moduli(const std::vector<ModalMeasurement>& measurements,
                                    const IdentifyOptions& options) {
  return ModulusSearch(measurements, options).run();
}

}  // namespace twang
