// SPDX-License-Identifier: GPL-3.0-or-later
// A C-shaped strip bent by 1 N and let go, in CalculiX and in twang, one after the other on the
// same mesh, material and step: seconds a step and the distance of the tip's motions.
//
//   beside_calculix [--threads 2] [--folder DIR]
//
// Without ccx it says so and ends.
#include "core/constants.hpp"
#include "fem/static_solve.hpp"
#include "fem/threads.hpp"
#include "simulate/integrators.hpp"

#include "bench/measure.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace twang;
using bench::seconds_since;
using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

constexpr double kModulus = 1e9;     // [Pa]
constexpr double kPoisson = 0.45;    // [-]
constexpr double kDensity = 1180.0;  // [kg/m³]
constexpr double kBeta = 1.6e-4;     // [s]
constexpr double kStep = 1e-4;       // [s]
constexpr int kFew = 5;              // steps of CalculiX; what both its runs share is start-up
constexpr int kMany = 25;
constexpr double kForce = 1.0;  // [N]

struct Strip {
  HexMesh mesh;
  std::vector<int> held;
  std::vector<int> tip;
};

/// 27 mm wide, 3 mm thick, of voxels of 1.5 mm; the lower arm's end is held, the upper one's
/// pulled.
Strip make_strip() {
  Rig rig;
  rig.name = "C-shaped strip";
  rig.materials.push_back({"part", kDensity, kPoisson, {}, {}});
  const auto add = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    rig.parts.push_back({"part", Box{1e-3 * low, 1e-3 * high}});
  };
  add({0.0, 0.0, 0.0}, {87.0, 27.0, 3.0});
  add({0.0, 0.0, 3.0}, {3.0, 27.0, 60.0});
  add({0.0, 0.0, 60.0}, {87.0, 27.0, 63.0});
  Strip strip;
  strip.mesh = mesh_part(rig, 1.5e-3, ElementKind::Hex8);
  for (int i = 0; i < strip.mesh.num_nodes(); ++i) {
    if (strip.mesh.nodes(0, i) < 86.9e-3) continue;
    (strip.mesh.nodes(2, i) < 30e-3 ? strip.held : strip.tip).push_back(i);
  }
  return strip;
}

std::string node_set(const char* name, const std::vector<int>& nodes) {
  std::string text = fmt::format("*NSET,NSET={}\n", name);
  for (const int node : nodes) text += fmt::format("{},\n", node + 1);
  return text;
}

void write_deck(const fs::path& path, const Strip& strip, int steps) {
  std::string text = "*NODE\n";
  const HexMesh& mesh = strip.mesh;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    text += fmt::format(
        "{},{:.9g},{:.9g},{:.9g}\n", i + 1, mesh.nodes(0, i), mesh.nodes(1, i), mesh.nodes(2, i));
  text += "*ELEMENT,TYPE=C3D8,ELSET=EALL\n";
  for (int e = 0; e < mesh.num_elements(); ++e) {
    text += fmt::format("{}", e + 1);
    for (int a = 0; a < 8; ++a) text += fmt::format(",{}", mesh.elements(a, e) + 1);
    text += "\n";
  }
  text += node_set("NFIX", strip.held) + node_set("NTIP", strip.tip);
  const double shear = kModulus / (2.0 * (1.0 + kPoisson));
  const double bulk = kModulus / (3.0 * (1.0 - 2.0 * kPoisson));
  text += fmt::format(
      "*MATERIAL,NAME=M\n*HYPERELASTIC,NEO HOOKE\n{:.9g},{:.9g}\n*DENSITY\n{}\n"
      "*DAMPING,ALPHA=0.,BETA={}\n*SOLID SECTION,ELSET=EALL,MATERIAL=M\n*BOUNDARY\nNFIX,1,3\n"
      "*STEP,NLGEOM,INC=100\n*STATIC,DIRECT\n0.5,1.\n*CLOAD\nNTIP,3,{:.12g}\n"
      "*NODE PRINT,NSET=NTIP,FREQUENCY=1\nU\n*EL "
      "PRINT,ELSET=EALL,FREQUENCY=1,TOTALS=ONLY\nELSE\n*END STEP\n"
      "*STEP,NLGEOM,INC=1000\n*DYNAMIC,DIRECT,ALPHA=0.\n{},{:.9g}\n*CLOAD,OP=NEW\n"
      "*NODE PRINT,NSET=NTIP,FREQUENCY=1\nU\n*EL "
      "PRINT,ELSET=EALL,FREQUENCY=1,TOTALS=ONLY\nELSE\n*END STEP\n",
      0.5 * shear,
      2.0 / bulk,
      kDensity,
      kBeta,
      -kForce / static_cast<double>(strip.tip.size()),
      kStep,
      steps * kStep);
  std::ofstream(path) << text;
}

/// Mean displacement of the tip along z after the static step and after each of the dynamic ones.
std::vector<double> read_tip(const fs::path& path) {
  std::ifstream file(path);
  std::vector<double> means;
  std::string line;
  double sum = 0.0;
  int count = 0;
  const auto close = [&] {
    if (count > 0) means.push_back(sum / count);
    sum = 0.0;
    count = 0;
  };
  while (std::getline(file, line)) {
    if (line.find("displacements") != std::string::npos) close();
    std::istringstream words(line);
    int node = 0;
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
    if (!(words >> node >> x >> y >> z)) continue;
    sum += z;
    ++count;
  }
  close();
  if (means.size() > 1) means.erase(means.begin());  // the static step's first half
  return means;
}

/// Seconds that ccx takes for so many steps; the tip's motion.
double run_calculix(
    const fs::path& folder, const Strip& strip, int steps, int threads, std::vector<double>& tip) {
  const std::string job = fmt::format("dyn{}", steps);
  write_deck(folder / (job + ".inp"), strip, steps);
  const std::string command =
      fmt::format("cd '{}' && OMP_NUM_THREADS={} CCX_NPROC_EQUATION_SOLVER={} ccx {} > {}.log 2>&1",
                  folder.string(),
                  threads,
                  threads,
                  job,
                  job);
  const auto start = Clock::now();
  if (std::system(command.c_str()) != 0) return kNaN;
  const double seconds = seconds_since(start);
  tip = read_tip(folder / (job + ".dat"));
  return seconds;
}

double mean_z(const std::vector<int>& nodes, const Eigen::VectorXd& u) {
  double sum = 0.0;
  for (const int node : nodes) sum += u[3 * node + 2];
  return sum / static_cast<double>(nodes.size());
}

/// Seconds a step, with everything that a step needs, factorizations too; the tip's motion.
double run_twang(const Strip& strip, int steps, std::vector<double>& tip) {
  const ElasticBody body(strip.mesh, {{kModulus, kPoisson, kDensity, kBeta, 0.0}});
  StaticLoad load;
  load.force = Eigen::VectorXd::Zero(strip.mesh.num_dofs());
  for (const int node : strip.tip)
    load.force[3 * node + 2] = -kForce / static_cast<double>(strip.tip.size());
  const StaticResult bent = solve_static(body, strip.held, load);
  BodyState state{bent.u, Eigen::VectorXd::Zero(bent.u.size()), 0.0};
  IntegratorOptions options;
  options.step_s = kStep;
  Integrator integrator(body, strip.held, options);
  tip.clear();
  const RunSummary summary = run(integrator, state, kStep, steps * kStep, [&](const BodyState& at) {
    tip.push_back(mean_z(strip.tip, at.u));
  });
  if (!bent.usable() || !summary.usable()) return kNaN;
  return summary.wall_s / summary.steps;
}

int compare(const fs::path& folder, int threads) {
  fs::create_directories(folder);
  const Strip strip = make_strip();
  fmt::print(
      "{} C3D8 / hex8 elements, h {} s, {} threads\n", strip.mesh.num_elements(), kStep, threads);
  std::vector<double> peer;
  const double peer_few = run_calculix(folder, strip, kFew, threads, peer);
  const double peer_many = run_calculix(folder, strip, kMany, threads, peer);
  if (peer.empty() || !std::isfinite(peer_few) || !std::isfinite(peer_many)) {
    fmt::print("ccx failed, see {}\n", folder.string());
    return 1;
  }
  std::vector<double> own;
  const double own_step = run_twang(strip, kMany, own);
  const double peer_step = (peer_many - peer_few) / (kMany - kFew);
  double largest = 0.0;
  double apart = 0.0;
  for (std::size_t i = 0; i < std::min(peer.size(), own.size()); ++i) {
    largest = std::max(largest, std::abs(peer[i]));
    apart = std::max(apart, std::abs(peer[i] - own[i]));
  }
  const bool complete = peer.size() == own.size() && peer.size() == kMany + 1U;
  fmt::print("CalculiX {:.4f} s a step, twang {:.4f} s: {:.1f} times as fast\n",
             peer_step,
             own_step,
             peer_step / own_step);
  fmt::print(
      "tip bent by {:.4f} and {:.4f} mm; after {} steps {:.4f} and {:.4f} mm; motions at most "
      "{:.3f} % of the deflection apart\n",
      1e3 * peer.front(),
      1e3 * own.front(),
      own.size() - 1,
      1e3 * peer.back(),
      1e3 * own.back(),
      100.0 * apart / largest);
  if (!complete) fmt::print("CalculiX wrote {} states, twang {}\n", peer.size(), own.size());
  return complete && apart < 1e-3 * largest && peer_step > 10.0 * own_step ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  int threads = 2;
  std::string folder = (fs::temp_directory_path() / "twang_beside_calculix").string();
  CLI::App app("A strip's vibration in CalculiX and in twang");
  app.add_option("--threads", threads, "of each");
  app.add_option("--folder", folder, "for CalculiX's files");
  CLI11_PARSE(app, argc, argv);
  if (std::system("command -v ccx > /dev/null") != 0) {
    fmt::print("ccx is not installed (Debian: calculix-ccx), there is nothing to stand beside\n");
    return 0;
  }
  fix_threads(threads);
  return compare(folder, threads);
}
