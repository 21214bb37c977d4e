// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/material_file.hpp"

#include "core/atomic_file.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <set>

namespace twang {
namespace {

using nlohmann::json;
using test::holds;
using test::refusal_of;
using test::TemporaryFolder;

/// Every member has a value of its own and none its default, so that a swap shows.
Material distinct_material() {
  Material m;
  m.material = "clear resin";
  m.youngs_modulus_identified_pa = 1.66e9 / 3;
  m.youngs_modulus_identified_sigma_pa = 2.1e7 / 3;
  m.youngs_modulus_numerical_pa = 0.65e9 / 3;
  m.numerical_element = "hex8";
  m.numerical_dx_mm = 1.5;
  m.numerical_elements = 5443;
  m.rig_sha256 = "abcdef";
  m.damping_stiffness_b_s = 1.64e-4 / 3;
  m.damping_stiffness_b_sigma_s = 1e-6 / 3;
  m.damping_mass_a_per_s = 0.125;
  m.poissons_ratio = 0.45;
  m.density_kg_m3 = 1205.0;
  m.reported_youngs_modulus_pa = 1.9e9;
  m.frequency_hz = 48.535;
  m.frequency_sigma_hz = 0.012;
  m.decay_per_s = 7.66;
  m.decay_sigma_per_s = 0.07;
  m.lambda_per_s2 = 93057.25;
  m.tan_delta = 0.0502;
  m.amplitude_range = {0.003, 0.11};
  m.amplitude_unit = "rad";
  m.eigenmode = 3;
  m.eigenmode_reason = "the markers move as in it";
  m.refinement =
      Refinement{1.1e9, 3.1e-4, -0.031, 0.0032, 0.033, 0.0034, 9.5, 0.35, 0.0036, 0.037, 381, 13};
  m.uncertainty = {0.011, 0.012, 0.013, 0.014, 0.015, 0.016, 0.017};
  m.validation = {0.021, -0.022, 0.023};
  m.specimen = {{"batch", "A7"}, {"note", "Größe \"5\""}};
  m.provenance.twang_version = "9.8.7";
  m.provenance.inputs = {{"strip.toml", "12ab"}, {"film.mp4", "34cd"}};
  m.provenance.options = {{"dx", "1.5"}, {"element", "hex8e"}};
  m.provenance.date = "2024-03-01T12:00:00Z";
  return m;
}

void expect_equal(const Material& found, const Material& expected) {
  // Compares the text both write, then each member that text could hide by a shared key.
  EXPECT_EQ(material_to_json(found), material_to_json(expected));
  EXPECT_EQ(found.material, expected.material);
  EXPECT_EQ(found.youngs_modulus_identified_pa, expected.youngs_modulus_identified_pa);
  EXPECT_EQ(found.youngs_modulus_identified_sigma_pa, expected.youngs_modulus_identified_sigma_pa);
  EXPECT_EQ(found.youngs_modulus_numerical_pa, expected.youngs_modulus_numerical_pa);
  EXPECT_EQ(found.numerical_element, expected.numerical_element);
  EXPECT_EQ(found.numerical_dx_mm, expected.numerical_dx_mm);
  EXPECT_EQ(found.numerical_elements, expected.numerical_elements);
  EXPECT_EQ(found.rig_sha256, expected.rig_sha256);
  EXPECT_EQ(found.damping_stiffness_b_s, expected.damping_stiffness_b_s);
  EXPECT_EQ(found.damping_stiffness_b_sigma_s, expected.damping_stiffness_b_sigma_s);
  EXPECT_EQ(found.damping_mass_a_per_s, expected.damping_mass_a_per_s);
  EXPECT_EQ(found.poissons_ratio, expected.poissons_ratio);
  EXPECT_EQ(found.density_kg_m3, expected.density_kg_m3);
  EXPECT_EQ(found.reported_youngs_modulus_pa, expected.reported_youngs_modulus_pa);
  EXPECT_EQ(found.frequency_hz, expected.frequency_hz);
  EXPECT_EQ(found.frequency_sigma_hz, expected.frequency_sigma_hz);
  EXPECT_EQ(found.decay_per_s, expected.decay_per_s);
  EXPECT_EQ(found.decay_sigma_per_s, expected.decay_sigma_per_s);
  EXPECT_EQ(found.lambda_per_s2, expected.lambda_per_s2);
  EXPECT_EQ(found.tan_delta, expected.tan_delta);
  EXPECT_EQ(found.amplitude_range, expected.amplitude_range);
  EXPECT_EQ(found.amplitude_unit, expected.amplitude_unit);
  EXPECT_EQ(found.eigenmode, expected.eigenmode);
  EXPECT_EQ(found.eigenmode_reason, expected.eigenmode_reason);
  ASSERT_TRUE(found.refinement.has_value());
  EXPECT_EQ(found.refinement->modulus_change_rel, expected.refinement->modulus_change_rel);
  EXPECT_EQ(found.refinement->damping_sigma_rel, expected.refinement->damping_sigma_rel);
  EXPECT_EQ(found.uncertainty.statistical, expected.uncertainty.statistical);
  EXPECT_EQ(found.uncertainty.repeats, expected.uncertainty.repeats);
  EXPECT_EQ(found.uncertainty.mesh, expected.uncertainty.mesh);
  EXPECT_EQ(found.uncertainty.clock, expected.uncertainty.clock);
  EXPECT_EQ(found.uncertainty.dimension, expected.uncertainty.dimension);
  EXPECT_EQ(found.uncertainty.density, expected.uncertainty.density);
  EXPECT_EQ(found.uncertainty.poissons_ratio, expected.uncertainty.poissons_ratio);
  EXPECT_EQ(found.validation.rms_rel, expected.validation.rms_rel);
  EXPECT_EQ(found.validation.frequency_error_rel, expected.validation.frequency_error_rel);
  EXPECT_EQ(found.validation.decay_error_rel, expected.validation.decay_error_rel);
  EXPECT_EQ(found.specimen, expected.specimen);
  EXPECT_EQ(found.provenance.twang_version, expected.provenance.twang_version);
  EXPECT_EQ(found.provenance.options, expected.provenance.options);
  EXPECT_EQ(found.provenance.date, expected.provenance.date);
  ASSERT_EQ(found.provenance.inputs.size(), expected.provenance.inputs.size());
  for (std::size_t i = 0; i < found.provenance.inputs.size(); ++i) {
    EXPECT_EQ(found.provenance.inputs[i].file, expected.provenance.inputs[i].file);
    EXPECT_EQ(found.provenance.inputs[i].sha256, expected.provenance.inputs[i].sha256);
  }
}

TEST(MaterialFile, DistinctValuesReadBackExactly) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "material.json";
  write_material(path, distinct_material());
  EXPECT_EQ(folder.num_entries(), 1U);
  expect_equal(read_material(path), distinct_material());
}

TEST(MaterialFile, EachValueStandsUnderItsOwnKeyOfTheContract) {
  const json file = json::parse(material_to_json(distinct_material()));
  EXPECT_EQ(file.at("format"), "twang-material/1");
  EXPECT_EQ(file.at("youngs_modulus_identified_pa"), 1.66e9 / 3);
  EXPECT_EQ(file.at("youngs_modulus_numerical_pa"), 0.65e9 / 3);
  EXPECT_EQ(file.at("numerical_dx_mm"), 1.5);
  EXPECT_EQ(file.at("numerical_elements"), 5443);
  EXPECT_EQ(file.at("damping_stiffness_b_s"), 1.64e-4 / 3);
  EXPECT_EQ(file.at("damping_mass_a_per_s"), 0.125);
  EXPECT_EQ(file.at("frequency_hz"), 48.535);
  EXPECT_EQ(file.at("decay_per_s"), 7.66);
  EXPECT_EQ(file.at("amplitude_range"), json::array({0.003, 0.11}));
  EXPECT_EQ(file.at("uncertainty").at("dimension"), 0.015);
  EXPECT_EQ(file.at("validation").at("decay_error_rel"), 0.023);
  EXPECT_EQ(file.at("provenance").at("inputs").at(1).at("sha256"), "34cd");
}

TEST(MaterialFile, WhatIsNotFiniteIsNullAndReadsBackAsNan) {
  Material material = distinct_material();
  material.validation = {};
  material.frequency_sigma_hz = std::numeric_limits<double>::infinity();
  material.amplitude_range[1] = kNaN;
  material.reported_youngs_modulus_pa.reset();
  const std::string text = material_to_json(material);
  const json file = json::parse(text);
  EXPECT_TRUE(file.at("validation").at("rms_rel").is_null());
  EXPECT_TRUE(file.at("frequency_sigma_hz").is_null());
  EXPECT_FALSE(file.contains("reported_youngs_modulus_pa"));
  const TemporaryFolder folder;
  const Material read = read_material(folder.write("m.json", text));
  EXPECT_TRUE(std::isnan(read.validation.rms_rel));
  EXPECT_TRUE(std::isnan(read.frequency_sigma_hz));
  EXPECT_TRUE(std::isnan(read.amplitude_range[1]));
  EXPECT_EQ(read.amplitude_range[0], 0.003);
  EXPECT_FALSE(read.reported_youngs_modulus_pa.has_value());
}

TEST(MaterialFile, WritesBytesThatAreNotUtf8AsReplacementCharacters) {
  Material material = distinct_material();
  material.provenance.inputs[0].file = "film\xff.mp4";
  EXPECT_EQ(json::parse(material_to_json(material))["provenance"]["inputs"][0]["file"],
            "film\xEF\xBF\xBD.mp4");
}

TEST(MaterialFile, RefusesAFileThatLacksAnyKeyOfTheContract) {
  const json sound = json::parse(material_to_json(distinct_material()));
  const std::set<std::string> optional = {"specimen",
                                          "amplitude_unit",
                                          "reported_youngs_modulus_pa",
                                          "eigenmode",
                                          "eigenmode_reason",
                                          "refinement"};
  const TemporaryFolder folder;
  int refused = 0;
  for (const auto& [key, value] : sound.items()) {
    json faulty = sound;
    faulty.erase(key);
    const std::filesystem::path path = folder.write("m.json", faulty.dump());
    if (optional.contains(key)) {
      EXPECT_NO_THROW((void)read_material(path)) << key;
      continue;
    }
    EXPECT_EQ(refusal_of([&] { (void)read_material(path); }),
              path.string() + ": " + key + " is missing");
    ++refused;
  }
  EXPECT_EQ(refused, 24);
}

TEST(MaterialFile, RefusesValuesOfTheWrongTypeOrSign) {
  const json sound = json::parse(material_to_json(distinct_material()));
  const TemporaryFolder folder;
  const auto refusal = [&](const char* pointer, const json& value) {
    json faulty = sound;
    faulty[json::json_pointer(pointer)] = value;
    const std::filesystem::path path = folder.write("m.json", faulty.dump());
    return refusal_of([&] { (void)read_material(path); });
  };
  EXPECT_TRUE(holds(refusal("/format", "twang-material/2"),
                    "format is \"twang-material/2\", must be \"twang-material/1\""));
  EXPECT_TRUE(holds(refusal("/material", 7), "m.json: material is 7, must be a text"));
  EXPECT_TRUE(holds(refusal("/youngs_modulus_identified_pa", -1.5),
                    "youngs_modulus_identified_pa is -1.5, must be a number > 0"));
  EXPECT_TRUE(holds(refusal("/youngs_modulus_numerical_pa", nullptr), "is null, must be a number"));
  EXPECT_TRUE(holds(refusal("/numerical_dx_mm", 0), "must be a number > 0"));
  EXPECT_TRUE(holds(refusal("/numerical_elements", 1.5), "must be a whole number >= 0"));
  EXPECT_TRUE(holds(refusal("/numerical_elements", 1e10), "must be a whole number >= 0"));
  EXPECT_TRUE(holds(refusal("/numerical_elements", -3), "must be a whole number >= 0"));
  EXPECT_TRUE(holds(refusal("/damping_stiffness_b_s", -1e-4), "must be a number >= 0"));
  EXPECT_TRUE(holds(refusal("/damping_mass_a_per_s", nullptr), "must be a finite number"));
  EXPECT_TRUE(holds(refusal("/poissons_ratio", 0.5), "is 0.5, must be between -1 and 0.5"));
  EXPECT_TRUE(holds(refusal("/density_kg_m3", "1"), "density_kg_m3 is \"1\", must be a number"));
  EXPECT_TRUE(holds(refusal("/reported_youngs_modulus_pa", 0), "must be a number > 0"));
  EXPECT_TRUE(holds(refusal("/amplitude_range", 3), "must be an array"));
  EXPECT_TRUE(holds(refusal("/amplitude_range", json::array({1})), "must be two numbers"));
  EXPECT_TRUE(holds(refusal("/amplitude_range", json::array({1, "2"})), "must be two numbers"));
  EXPECT_TRUE(holds(refusal("/uncertainty", 0.1), "uncertainty is 0.1, must be an object"));
  EXPECT_TRUE(holds(refusal("/uncertainty/mesh", "a"), "uncertainty.mesh is \"a\""));
  EXPECT_TRUE(holds(refusal("/specimen", json::array()), "specimen is [], must be an object"));
  EXPECT_TRUE(holds(refusal("/provenance/inputs", 5), "provenance.inputs is 5, must be an array"));
  EXPECT_TRUE(holds(refusal("/provenance/inputs/0", 5), "must be a list of objects"));
  EXPECT_TRUE(holds(refusal("/provenance/inputs/0/sha256", 5), "must be a list of objects"));
}

TEST(MaterialFile, RefusesWhatIsNoMaterialFile) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::filesystem::path& path) {
    return refusal_of([&] { (void)read_material(path); });
  };
  EXPECT_TRUE(holds(refusal(folder.path() / "none.json"), "no such file"));
  EXPECT_TRUE(holds(refusal(folder.path()), "is a folder"));
  EXPECT_TRUE(holds(refusal(folder.write("empty.json", "")), "empty.json: is not valid JSON"));
  EXPECT_TRUE(holds(refusal(folder.write("cut.json", "{\"format\": ")), "is not valid JSON"));
  EXPECT_TRUE(holds(refusal(folder.write("list.json", "[1]")), "holds no JSON object"));
  EXPECT_TRUE(holds(refusal(folder.write("other.json", "{}")), "format is missing"));
}

TEST(UncertaintyBudget, TotalIsTheRootSumOfSquaresOfAllSeven) {
  // 1 + 4 + 4 + 16 + 16 + 4 + 4 = 49
  const UncertaintyBudget budget = {0.01, 0.02, 0.02, 0.04, 0.04, 0.02, 0.02};
  EXPECT_NEAR(budget.total(), 0.07, 1e-16);  // rounding
  EXPECT_EQ(UncertaintyBudget{}.total(), 0.0);
}

}  // namespace
}  // namespace twang
