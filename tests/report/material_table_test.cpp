// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/material_table.hpp"

#include "core/error.hpp"
#include "core/material_file.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <map>
#include <sstream>

namespace twang {
namespace {

/// Distinct values everywhere, so that no two fields can be swapped unseen.
Material stiff_material() {
  Material material;
  material.material = "Rigid_1, vertical & 45 %";
  material.youngs_modulus_identified_pa = 1.66349e9;
  material.youngs_modulus_identified_sigma_pa = 0.0374e9;
  material.youngs_modulus_numerical_pa = 0.65123456789e9;
  material.numerical_element = "hex8";
  material.numerical_dx_mm = 1.5;
  material.numerical_elements = 5400;
  material.rig_sha256 = "abc123";
  material.damping_stiffness_b_s = 1.642e-4;
  material.damping_stiffness_b_sigma_s = 3.14e-6;
  material.damping_mass_a_per_s = 0.25;
  material.poissons_ratio = 0.45;
  material.density_kg_m3 = 1205.0;
  material.reported_youngs_modulus_pa = 1.9e9;
  material.frequency_hz = 55.4249;
  material.frequency_sigma_hz = 0.021;
  material.decay_per_s = 9.95;
  material.decay_sigma_per_s = 0.18;
  material.lambda_per_s2 = 121361.7;
  material.tan_delta = 0.05721;
  material.amplitude_range = {0.125, 4.75};
  material.amplitude_unit = "mm";
  material.uncertainty = {0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007};
  material.validation = {0.011, -0.012, 0.013};
  material.provenance.twang_version = "0.1.0";
  material.provenance.date = "2024-05-06T07:08:09Z";
  return material;
}

/// Soft, and with nothing known but what must be.
Material soft_material() {
  Material material;
  material.material = "Soft | black";
  material.youngs_modulus_identified_pa = 6.32e5;
  material.youngs_modulus_numerical_pa = 4.625e5;
  material.numerical_element = "hex20";
  material.numerical_dx_mm = 0.75;
  material.numerical_elements = 12;
  material.damping_stiffness_b_s = 9.1e-2;
  return material;
}

const std::vector<Material> kBoth = {stiff_material(), soft_material()};

TEST(MaterialTable, TextIsAlignedAndRoundedToItsSigmas) {
  EXPECT_EQ(format_material_table(kBoth, TableFormat::Text),
            "Material                  Reported E [MPa]  Identified E [MPa]  Numerical Eₙ [MPa]  "
            "Mesh of Eₙ                   "
            " Damping b [ms]          f [Hz]   tan δ\n"
            "------------------------  ----------------  ------------------  ------------------  "
            "---------------------------  "
            "---------------  --------------  ------\n"
            "Rigid_1, vertical & 45 %              1900           1663 ± 37               651.2  "
            "hex8, 1.5 mm, 5400 elements  "
            "0.1642 ± 0.0031  55.425 ± 0.021  0.0572\n"
            "Soft | black                             –              0.6320              0.4625  "
            "hex20, 0.75 mm, 12 elements  "
            "          91.00               –       –\n");
}

TEST(MaterialTable, MarkdownEscapesItsPipes) {
  EXPECT_EQ(format_material_table({soft_material()}, TableFormat::Markdown),
            "| Material      | Reported E \\[MPa\\] | Identified E \\[MPa\\] | Numerical Eₙ "
            "\\[MPa\\] | Mesh of Eₙ                "
            "  | Damping b \\[ms\\] | f \\[Hz\\] | tan δ |\n"
            "| ------------- | -----------------: | -------------------: | -------------------: | "
            "--------------------------- "
            "| ---------------: | -------: | ----: |\n"
            "| Soft \\| black |                  – |               0.6320 |               0.4625 | "
            "hex20, 0.75 mm, 12 elements "
            "|            91.00 |        – |     – |\n");
}

TEST(MaterialTable, LatexIsATabularOfBooktabs) {
  EXPECT_EQ(
      format_material_table({stiff_material()}, TableFormat::Latex),
      "% needs \\usepackage{booktabs}\n"
      "\\begin{tabular}{lrrrlrrr}\n"
      "  \\toprule\n"
      "  Material                    & Reported E {[}MPa{]} & Identified E {[}MPa{]} & Numerical "
      "E$_n$ {[}MPa{]} & Mesh of "
      "E$_n$               &  Damping b {[}ms{]} &         f {[}Hz{]} & tan $\\delta$ \\\\\n"
      "  \\midrule\n"
      "  Rigid\\_1, vertical \\& 45 \\% &                 1900 &          1663 $\\pm$ 37 &         "
      "            651.2 & hex8, "
      "1.5 mm, 5400 elements & 0.1642 $\\pm$ 0.0031 & 55.425 $\\pm$ 0.021 &       0.0572 \\\\\n"
      "  \\bottomrule\n"
      "\\end{tabular}\n");
}

TEST(MaterialTable, CsvCarriesEveryFieldExactly) {
  std::istringstream lines(
      format_material_table({soft_material(), stiff_material()}, TableFormat::Csv));
  std::string head;
  std::string unknown;
  std::string row;
  std::getline(lines, head);
  std::getline(lines, unknown);
  std::getline(lines, row);
  EXPECT_EQ(head,
            "material,reported_youngs_modulus_pa,youngs_modulus_identified_pa,youngs_modulus_"
            "identified_sigma_pa,"
            "youngs_modulus_numerical_pa,numerical_element,numerical_dx_mm,numerical_elements,"
            "damping_stiffness_b_s,"
            "damping_stiffness_b_sigma_s,damping_mass_a_per_s,poissons_ratio,density_kg_m3,"
            "frequency_hz,frequency_sigma_hz,"
            "decay_per_s,decay_sigma_per_s,lambda_per_s2,tan_delta,amplitude_range.min,amplitude_"
            "range.max,amplitude_unit,"
            "uncertainty.statistical,uncertainty.repeats,uncertainty.mesh,uncertainty.clock,"
            "uncertainty.dimension,"
            "uncertainty.density,uncertainty.poissons_ratio,validation.rms_rel,validation."
            "frequency_error_rel,"
            "validation.decay_error_rel,rig_sha256,twang_version,date");
  EXPECT_EQ(row,
            "\"Rigid_1, vertical & 45 "
            "%\",1900000000,1663490000,37400000,651234567.89,hex8,1.5,5400,0.0001642,3.14e-06,"
            "0.25,0.45,1205,55.4249,0.021,9.95,0.18,121361.7,0.05721,0.125,4.75,mm,0.001,0.002,0."
            "003,0.004,0.005,0.006,"
            "0.007,0.011,-0.012,0.013,abc123,0.1.0,2024-05-06T07:08:09Z");
  EXPECT_EQ(unknown.substr(0, 36), "Soft | black,nan,632000,nan,462500,h");
}

TEST(MaterialTable, JsonIsAnArrayOfMaterialFiles) {
  const nlohmann::json table =
      nlohmann::json::parse(format_material_table(kBoth, TableFormat::Json));
  ASSERT_EQ(table.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(table[i], nlohmann::json::parse(material_to_json(kBoth[i])));
  EXPECT_EQ(table[0].at("youngs_modulus_numerical_pa").get<double>(), 0.65123456789e9);
}

TEST(MaterialTable, OfNothingIsAHead) {
  EXPECT_EQ(format_material_table({}, TableFormat::Json), "[]\n");
  const std::string csv = format_material_table({}, TableFormat::Csv);
  EXPECT_EQ(csv.find('\n'), csv.size() - 1);
}

TEST(TableFormat, IsKnownByItsName) {
  const std::map<std::string, TableFormat> names = {{"text", TableFormat::Text},
                                                    {"csv", TableFormat::Csv},
                                                    {"markdown", TableFormat::Markdown},
                                                    {"latex", TableFormat::Latex},
                                                    {"json", TableFormat::Json}};
  for (const auto& [name, format] : names) EXPECT_EQ(table_format_from(name), format) << name;
  try {
    static_cast<void>(table_format_from("CSV"));
    FAIL() << "must throw";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "table format is \"CSV\", must be one of text, csv, markdown, latex, json");
  }
}

TEST(TextWithSigma, RoundsWhereTheSecondDigitOfSigmaStands) {
  EXPECT_EQ(text_with_sigma(1663.49, 37.4), "1663 ± 37");
  EXPECT_EQ(text_with_sigma(1663.49, 374.0), "1660 ± 370");
  EXPECT_EQ(text_with_sigma(1666.0, 1234.0), "1700 ± 1200");
  EXPECT_EQ(text_with_sigma(1663.49, 3.74), "1663.5 ± 3.7");
  EXPECT_EQ(text_with_sigma(55.4249, 0.0214), "55.425 ± 0.021");
  EXPECT_EQ(text_with_sigma(-2.0, 0.5), "-2.00 ± 0.50");
}

TEST(TextWithSigma, KnowsThatRoundingCanAddADigitToSigma) {
  // 0.0996 to two digits is 0.10: its second digit stands at the second decimal.
  EXPECT_EQ(text_with_sigma(1.2345, 0.0996), "1.23 ± 0.10");
  EXPECT_EQ(text_with_sigma(1234.5, 99.6), "1230 ± 100");
}

TEST(TextWithSigma, GivesFourDigitsWithoutASigma) {
  EXPECT_EQ(text_with_sigma(1663.49, kNaN), "1663");
  EXPECT_EQ(text_with_sigma(0.632, 0.0), "0.6320");
  EXPECT_EQ(text_with_sigma(kNaN, 1.0), "–");
}

}  // namespace
}  // namespace twang
