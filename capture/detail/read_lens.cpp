// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/lens.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace twang {
namespace {

constexpr std::size_t kMostBytes = 1U << 20U;  // a calibration with all its views is far smaller
constexpr int kMostPixels = 1 << 16;
constexpr int kBorderPoints = 32;  // along each side, where folding is looked for

/// A camera file opened for reading, with messages that name it.
class CameraFile {
 public:
  explicit CameraFile(const std::filesystem::path& path) : m_name(path.string()) {
    std::string text = read_file(path);
    const std::size_t start = text.find_first_not_of(" \t\r\n");
    if (start == std::string::npos) refuse("is empty", "a camera calibration");
    if (text.size() > kMostBytes || text.find('\0') != std::string::npos) {
      refuse("is no text file of ordinary size", "a camera calibration");
    }
    // ROS writes plain YAML, which OpenCV reads under its own heading only.
    if (std::string_view("%{<").find(text[start]) == std::string_view::npos) {
      text = "%YAML:1.0\n---\n" + text;
    }
    try {
      m_storage.open(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    } catch (const cv::Exception&) {
      m_storage.release();
    }
    if (!m_storage.isOpened()) refuse("cannot be read", "YAML, XML or JSON of OpenCV or ROS");
  }

  [[noreturn]] void refuse(std::string_view what, std::string_view expected) const {
    throw InputError(fmt::format("{}: {}, must be {}", m_name, what, expected));
  }

  [[nodiscard]] bool has(const char* key) const { return !m_storage[key].empty(); }

  [[nodiscard]] int pixels(const char* key) const {
    const std::vector<double> value = numbers(key);
    if (value.size() != 1 || !(value[0] >= 1.0 && value[0] <= kMostPixels) ||
        value[0] != std::floor(value[0])) {
      refuse(fmt::format("{} is {}", key, text_of(value)),
             fmt::format("a whole number of pixels from 1 to {}", kMostPixels));
    }
    return static_cast<int>(value[0]);
  }

  [[nodiscard]] std::string text(const char* key) const {
    const cv::FileNode node = m_storage[key];
    return node.isString() ? node.string() : std::string();
  }

  /// A number, a list of numbers, or a matrix row by row.
  [[nodiscard]] std::vector<double> numbers(const char* key) const {
    if (!has(key)) refuse(fmt::format("{} is missing", key), "there");
    std::vector<double> values;
    try {
      values = numbers_of(m_storage[key]);
    } catch (const cv::Exception&) {
      refuse(fmt::format("{} cannot be read", key), "a matrix of numbers");
    }
    const bool finite =
        std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
    if (values.empty() || !finite) {
      refuse(fmt::format("{} is {}", key, text_of(values)), "finite numbers");
    }
    return values;
  }

  static std::string text_of(const std::vector<double>& values) {
    return values.empty() ? "no number" : fmt::format("{}", fmt::join(values, ", "));
  }

 private:
  static std::vector<double> numbers_of(const cv::FileNode& node) {
    if (node.isInt() || node.isReal()) return {static_cast<double>(node)};
    std::vector<double> values;
    if (node.isSeq()) {
      for (const auto& entry : node) {
        if (!entry.isInt() && !entry.isReal()) return {};
        values.push_back(static_cast<double>(entry));
      }
    }
    if (!node.isMap()) return values;
    if (node["dt"].empty()) return numbers_of(node["data"]);  // ROS
    cv::Mat matrix;
    node >> matrix;
    matrix.convertTo(matrix, CV_64F);
    if (matrix.channels() == 1) values.assign(matrix.begin<double>(), matrix.end<double>());
    return values;
  }

  std::string m_name;
  cv::FileStorage m_storage;
};

void read_matrix(const CameraFile& file, Lens& lens) {
  const std::vector<double> K = file.numbers("camera_matrix");
  const bool sound = K.size() == 9 && K[0] > 0.0 && K[4] > 0.0 && K[1] == 0.0 && K[3] == 0.0 &&
                     K[6] == 0.0 && K[7] == 0.0 && K[8] == 1.0;
  if (!sound) {
    file.refuse(fmt::format("camera_matrix is {}", CameraFile::text_of(K)),
                "f_x, 0, c_x, 0, f_y, c_y, 0, 0, 1 with f_x and f_y > 0");
  }
  lens.focal_px = {K[0], K[4]};
  lens.centre_px = {K[2], K[5]};
}

bool is_fisheye(const CameraFile& file) {
  const std::string model = file.text("distortion_model");
  static const std::set<std::string, std::less<>> kPolynomial = {
      "", "plumb_bob", "rational_polynomial"};
  if (model == "equidistant" || model == "fisheye") return true;
  if (!kPolynomial.contains(model)) {
    file.refuse(fmt::format("distortion_model is '{}'", model),
                "plumb_bob, rational_polynomial, equidistant or fisheye");
  }
  return file.has("fisheye_model") && file.numbers("fisheye_model").front() != 0.0;
}

void read_distortion(const CameraFile& file, Lens& lens) {
  const char* key = file.has("dist_coeffs") && !file.has("distortion_coefficients")
                        ? "dist_coeffs"
                        : "distortion_coefficients";
  const std::vector<double> values = file.numbers(key);
  const bool fisheye = is_fisheye(file);
  static const std::set<std::size_t> kCounts = {4, 5, 8, 12, 14};
  if (fisheye ? values.size() != 4 : !kCounts.contains(values.size())) {
    file.refuse(fmt::format("{} has {} entries", key, values.size()),
                fisheye ? "4 for a fisheye lens" : "4, 5, 8, 12 or 14");
  }
  lens.model = fisheye ? LensModel::Fisheye : LensModel::Polynomial;
  std::copy(values.begin(), values.end(), lens.coefficients.begin());
}

/// Whatever is seen within the picture must come from somewhere, and from one place only.
void check_that_nothing_folds(const CameraFile& file, const Lens& lens) {
  const Eigen::Vector2d corner(lens.width_px - 1, lens.height_px - 1);
  for (int i = 0; i <= kBorderPoints; ++i) {
    const double part = static_cast<double>(i) / kBorderPoints;
    for (const Eigen::Vector2d& at :
         {Eigen::Vector2d(part, 0.0), {part, 1.0}, {0.0, part}, {1.0, part}}) {
      const Eigen::Vector2d seen = at.cwiseProduct(corner);
      if (lens.undistorted(seen).allFinite()) continue;
      file.refuse(fmt::format("its lens folds the picture over at ({:.0f}, {:.0f}) px of {} x {}",
                              seen.x(),
                              seen.y(),
                              lens.width_px,
                              lens.height_px),
                  "valid up to the picture's border");
    }
  }
}

}  // namespace

Lens read_lens(const std::filesystem::path& path) {
  const CameraFile file(path);
  Lens lens;
  lens.width_px = file.pixels("image_width");
  lens.height_px = file.pixels("image_height");
  read_matrix(file, lens);
  read_distortion(file, lens);
  check_that_nothing_folds(file, lens);
  return lens;
}

}  // namespace twang
