// SPDX-License-Identifier: GPL-3.0-or-later
// The first ten modes of rigs on the coarsest mesh that keeps their shapes: mean error of the
// frequencies before and after the rescale of the modulus, hex8 and hex8e, with four and with ten
// shapes that must agree; where these two criteria choose different meshes, how far the motions of
// the two are apart.
//
//   coarsened_modes RIG... [--max-dofs 450000] [--growth 4] [--modes 4 10] [--frequencies]
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace twang;

struct Settings {
  std::vector<std::string> rigs;
  std::vector<int> criteria = {4, 10};
  LadderOptions ladder;
  bool frequencies = false;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void print_reference(const Rig& rig, const MeshLadder& ladder, double seconds) {
  fmt::print("\n{}\n", rig.name);
  for (const MeshRung& rung : ladder.reference) {
    fmt::print("  {:5} at {:.4g} mm: {:8} elements, f1 {:.6g} Hz at 1 Pa, {:.1f} s\n",
               to_string(rung.mesh.kind),
               rung.mesh.requested_dx_m * kMillimetresPerMetre,
               rung.mesh.num_elements(),
               rung.modes.natural_frequency_hz(0),
               rung.seconds);
  }
  fmt::print("  limit f1 {:.6g} Hz, E to {:.2g} %{}, {:.0f} s\n",
             std::sqrt(ladder.limit.lambda_per_s2) / kTwoPi,
             100.0 * ladder.limit.relative_sigma,
             ladder.convergent ? "" : ", not convergent",
             seconds);
}

std::string joined(const std::vector<double>& fractions) {
  std::string text;
  for (const double x : fractions) text += fmt::format(" {:.1f}", 100.0 * x);
  return text;
}

void print_candidates(const MeshLadder& ladder, int criterion, const Settings& settings) {
  const Eigenmodes& truth = ladder.reference.back().modes;
  for (const CoarseCandidate& candidate : ladder.candidates) {
    const bool chosen = &candidate == &ladder.chosen();
    fmt::print("  {:5} {:3} {:8.4g} {:8} {:10.1f} {:10.1f} {:9.1f} {:8.1f} {:8.3f} {}{}\n",
               to_string(candidate.element),
               criterion,
               candidate.dx_m * kMillimetresPerMetre,
               candidate.num_elements,
               100.0 * candidate.comparison.max_difference,
               100.0 * candidate.comparison.hausdorff,
               100.0 * candidate.mean_frequency_error_before,
               100.0 * candidate.mean_frequency_error_after,
               std::pow(kTwoPi * candidate.natural_frequency_hz(0), 2) / ladder.limit.lambda_per_s2,
               candidate.passes ? "passes" : "",
               chosen ? " *" : "");
    if (!settings.frequencies) continue;
    fmt::print("        shapes [%]:{}\n", joined(candidate.comparison.difference_by_mode));
    std::vector<double> errors;
    for (int i = 0; i < std::min(10, truth.count()); ++i) {
      errors.push_back(candidate.rescale * candidate.natural_frequency_hz(i) /
                           truth.natural_frequency_hz(i) -
                       1.0);
    }
    fmt::print("        frequencies after [%]:{}\n", joined(errors));
  }
}

/// How a point moves after a pull on it is let go, by a mesh's modes at its E_n and a damping ratio
/// of 2 % of the first: sum_i (phi_i . f / lambda_i) phi_i exp(-d_i t) cos(2 pi f_i t).
Eigen::MatrixXd motion_of(const MeshRung& rung,
                          double numerical_modulus_pa,
                          const Eigen::Vector3d& at,
                          const Eigen::VectorXd& times_s) {
  constexpr double kDampingRatio = 0.02;
  const double b_s =
      2.0 * kDampingRatio / std::sqrt(numerical_modulus_pa * rung.modes.lambda_per_s2(0));
  const MeshPoint point = locate(rung.mesh, at);
  const Eigen::Vector3d force(0.2, 0.5, -1.0);  // askew, so that it wakes modes of all kinds
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(times_s.size(), 3);
  for (int i = 0; i < rung.modes.count(); ++i) {
    const Eigen::Vector3d there = interpolate(point, rung.modes.shapes.col(i));
    const FrequencyAndDecay mode =
        frequency_and_decay(numerical_modulus_pa * rung.modes.lambda_per_s2(i), 0.0, b_s);
    const Eigen::ArrayXd swing = (-mode.decay_per_s * times_s.array()).exp() *
                                 (kTwoPi * mode.frequency_hz * times_s.array()).cos();
    motion += (there.dot(force) / rung.modes.lambda_per_s2(i) * swing.matrix()) * there.transpose();
  }
  return motion;
}

/// The motions of the meshes that two criteria choose, at the point that moves most in the first
/// mode, over ten periods of that.
void print_motions(const MeshLadder& ladder, const MeshRung& few, const MeshRung& many) {
  const MeshRung& finest = ladder.reference.back();
  const Eigen::VectorXd first = finest.modes.shapes.col(0);
  Eigen::Index node = 0;
  Eigen::Map<const Eigen::Matrix3Xd>(first.data(), 3, first.size() / 3)
      .colwise()
      .squaredNorm()
      .maxCoeff(&node);
  const double lambda = finest.modes.lambda_per_s2(0);
  const auto numerical = [&](const MeshRung& rung) {
    return rescaled_modulus(1.0, lambda, rung.modes.lambda_per_s2(0));
  };
  const Eigen::VectorXd times_s =
      Eigen::VectorXd::LinSpaced(4000, 0.0, 10.0 * kTwoPi / std::sqrt(lambda));
  const Eigen::Vector3d at = finest.mesh.nodes.col(node);
  const Eigen::MatrixXd a = motion_of(few, numerical(few), at, times_s);
  const Eigen::MatrixXd b = motion_of(many, numerical(many), at, times_s);
  const Eigen::MatrixXd c = motion_of(finest, 1.0, at, times_s);
  const double peak = c.rowwise().norm().maxCoeff();
  const auto rms = [&](const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
    return 100.0 * (x - y).norm() / std::sqrt(static_cast<double>(times_s.size())) / peak;
  };
  fmt::print(
      "  {} motion after a pull, rms over its peak: {:.4g} mm against {:.4g} mm {:.1f} %; "
      "against the reference {:.1f} % and {:.1f} %\n",
      to_string(few.mesh.kind),
      few.mesh.requested_dx_m * kMillimetresPerMetre,
      many.mesh.requested_dx_m * kMillimetresPerMetre,
      rms(a, b),
      rms(a, c),
      rms(b, c));
}

void bench(const std::string& file, const Settings& settings) {
  RigNeeds needs;
  needs.part = true;
  needs.clamp = true;
  const Rig rig = load_rig(file, needs);
  constexpr int kComputed = 14;  // ten, and those that may take their places
  LadderOptions options = settings.ladder;
  options.num_frequencies = kComputed;
  const auto start = std::chrono::steady_clock::now();
  MeshLadder ladder = build_mesh_ladder(rig, options);
  print_reference(rig, ladder, seconds_since(start));
  fmt::print("  {:5} {:>3} {:>8} {:>8} {:>10} {:>10} {:>9} {:>8} {:>8}\n",
             "",
             "of",
             "dx [mm]",
             "elements",
             "shapes [%]",
             "Hausd. [%]",
             "f err [%]",
             "after",
             "E/E_n");
  options.num_frequencies = 10;
  for (const ElementKind element : {ElementKind::Hex8, ElementKind::Hex8e}) {
    std::optional<MeshRung> few;
    for (const int criterion : settings.criteria) {
      options.coarse_element = element;
      options.num_modes = criterion;
      ladder = choose_again(rig, std::move(ladder), options);
      print_candidates(ladder, criterion, settings);
      const bool other = few && few->mesh.requested_dx_m != ladder.coarse.mesh.requested_dx_m;
      if (other) print_motions(ladder, *few, ladder.coarse);
      if (!few) few = ladder.coarse;
      std::fflush(stdout);
    }
  }
  for (const std::string& note : ladder.notes) fmt::print("  note: {}\n", note);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Frequencies of the coarsest mesh that keeps the mode shapes");
  app.add_option("rigs", settings.rigs, "rig files")->required();
  app.add_option("--max-dofs", settings.ladder.max_dofs, "of hex20 references");
  app.add_option("--growth", settings.ladder.enhanced_growth, "of hex8e references beyond");
  app.add_option("--modes", settings.criteria, "shapes that must agree");
  app.add_flag("--frequencies", settings.frequencies, "also the figures of each mode");
  CLI11_PARSE(app, argc, argv);
  try {
    for (const std::string& rig : settings.rigs) bench(rig, settings);
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  return 0;
}
