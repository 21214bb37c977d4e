// SPDX-License-Identifier: GPL-3.0-or-later
// `twang identify`: the moduli of two materials from the modes of two rigs.
#include "core/atomic_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

constexpr double kSoft_pa = 1.3e6;
constexpr double kStiff_pa = 1.7e9;

/// A beam of 40 x 8 x 4 mm of a stiff material with a soft root of that length.
std::string rig_text(double soft_mm, bool stated) {
  std::ostringstream text;
  text << "format = \"twang-rig/1\"\nname = \"root of " << soft_mm << " mm\"\n";
  for (const auto& [name, modulus_pa] : {std::pair{"soft", kSoft_pa}, {"stiff", kStiff_pa}}) {
    if (soft_mm == 0.0 && std::string(name) == "soft") continue;
    text << "[materials." << name << "]\ndensity_kg_m3 = 1150.0\npoissons_ratio = 0.35\n";
    if (stated) text << "youngs_modulus_pa = " << modulus_pa << "\n";
  }
  const auto part = [&](const char* material, double length_mm) {
    text << "[[part]]\nmaterial = \"" << material << "\"\nshape = \"box\"\n"
         << "min_mm = [0.0, 0.0, 0.0]\nmax_mm = [" << length_mm << ", 8.0, 4.0]\n";
  };
  part("stiff", 40.0);
  if (soft_mm > 0.0) part("soft", soft_mm);
  text << "[[clamp]]\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [0.0, 8.0, 4.0]\n";
  return text.str();
}

class Identify : public ::testing::Test {
 protected:
  /// The unknown rig's file, and beside it the first mode of the known one on a fine mesh.
  std::vector<std::string> pair(const std::string& name, double soft_mm) {
    const fs::path rig = m_folder.path() / (name + ".toml");
    const fs::path known = m_folder.path() / (name + "_known.toml");
    const fs::path modes = m_folder.path() / (name + ".json");
    write_file_atomically(rig, rig_text(soft_mm, false));
    write_file_atomically(known, rig_text(soft_mm, true));
    const CommandOutcome computed = run_twang({"modes",
                                               known.string(),
                                               "--dx",
                                               "1",
                                               "--element",
                                               "hex20",
                                               "--count",
                                               "1",
                                               "--json",
                                               "-"});
    EXPECT_EQ(computed.exit_code, 0) << computed.err;
    const double hz = nlohmann::json::parse(computed.out)["modes"][0]["natural_frequency_hz"];
    const nlohmann::json file = {{"format", "twang-modes/1"},
                                 {"modes",
                                  {{{"frequency_hz", hz},
                                    {"frequency_sigma_hz", 1e-3 * hz},
                                    {"decay_per_s", 0.0},
                                    {"decay_sigma_per_s", 0.01}}}}};
    write_file_atomically(modes, file.dump());
    return {rig.string(), modes.string()};
  }
  TemporaryFolder m_folder;
};

TEST_F(Identify, FindsASoftAndAStiffMaterialFromTwoRigs) {
  std::vector<std::string> arguments = {"identify"};
  for (const auto& files : {pair("hinged", 8.0), pair("plain", 0.0)}) {
    arguments.insert(arguments.end(), files.begin(), files.end());
  }
  arguments.insert(arguments.end(), {"--json", "-"});
  const CommandOutcome outcome = run_twang(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json found = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(found["format"], "twang-identified/1");
  EXPECT_TRUE(found["distinguishable"].get<bool>());
  for (const auto& [name, modulus_pa] : {std::pair{"soft", kSoft_pa}, {"stiff", kStiff_pa}}) {
    bool listed = false;
    for (const nlohmann::json& material : found["materials"]) {
      if (material["material"] != name) continue;
      listed = true;
      const double error =
          material["youngs_modulus_identified_pa"].get<double>() / modulus_pa - 1.0;
      EXPECT_LT(std::abs(error), 0.01) << name;
      EXPECT_LT(std::abs(error) * modulus_pa,
                3.0 * material["youngs_modulus_identified_sigma_pa"].get<double>())
          << name;
    }
    EXPECT_TRUE(listed) << name;
  }
}

TEST_F(Identify, RefusesWhatItCannotUse) {
  const auto files = pair("hinged", 8.0);
  const auto expect_refused = [](const std::vector<std::string>& arguments, const char* why) {
    const CommandOutcome outcome = run_twang(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.out.empty());
  };
  expect_refused({"identify", files[0]}, "pairs of a rig and its modes.json");
  expect_refused({"identify", files[0], files[1]}, "2 materials have no stated modulus");
  expect_refused({"identify", files[0], files[1], "--modes", "2"}, "holds 1 modes");
  expect_refused({"identify", files[0], files[1], "--mesh-modes", "0"}, "from 1 on");
  expect_refused({"identify", files[0], files[1], "--mesh-modes", "2,2"}, "each mode once");
  expect_refused({"identify", files[0], files[1], "--mesh-modes", ""}, "--mesh-modes is empty");
  expect_refused({"identify", files[0], files[0]}, "is no JSON");
  expect_refused({"identify", files[0], files[1], "--dx", "-1"}, "must be > 0 mm");
}

}  // namespace
}  // namespace twang::test
