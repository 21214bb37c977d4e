// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/vtk_data.hpp"

#include "core/error.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace twang {
namespace {

[[noreturn]] void fail(const VtkEncoding& encoding, const std::string& complaint) {
  throw InputError(fmt::format("{}: {}", encoding.file, complaint));
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

/// The lengths at the beginning of an array.
std::vector<std::uint64_t> lengths(const VtkEncoding& encoding,
                                   std::string_view bytes,
                                   std::size_t count) {
  const std::size_t width = encoding.long_headers ? 8 : 4;
  if (bytes.size() / width < count) fail(encoding, "an array is cut short");
  std::vector<std::uint64_t> result(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(&result[i], bytes.data() + i * width, width);  // little-endian
  }
  return result;
}

std::string expand(const VtkEncoding& encoding,
                   std::string_view bytes,
                   const std::vector<std::uint64_t>& header) {
  const std::uint64_t blocks = header[0];
  std::string result;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::uint64_t whole = b + 1 < blocks || header[2] == 0 ? header[1] : header[2];
    const std::uint64_t packed = header[3 + b];
    // zlib packs at most a thousandfold: a larger block is damage
    if (packed > bytes.size() || whole > 1100 * packed + 64)
      fail(encoding, "an array is cut short");
    std::string block(whole, '\0');
    uLongf length = whole;
    if (uncompress(reinterpret_cast<Bytef*>(block.data()),
                   &length,
                   reinterpret_cast<const Bytef*>(bytes.data()),
                   packed) != Z_OK ||
        length != whole) {
      fail(encoding, "an array cannot be expanded, the file is damaged");
    }
    bytes.remove_prefix(packed);
    result += block;
  }
  return result;
}

template <typename Value>
std::vector<double> convert(std::string_view bytes) {
  std::vector<double> values(bytes.size() / sizeof(Value));
  for (std::size_t i = 0; i < values.size(); ++i) {
    Value value;
    std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
    values[i] = static_cast<double>(value);
  }
  return values;
}

}  // namespace

std::string decode_base64(const VtkEncoding& encoding, std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int num_bits = 0;
  for (const char c : text) {
    if (is_blank(c)) continue;
    if (c == '=') break;
    const int digit = base64_digit(c);
    if (digit < 0) fail(encoding, fmt::format("an array holds '{}', must be base64", c));
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    num_bits += 6;
    if (num_bits < 8) continue;
    num_bits -= 8;
    bytes += static_cast<char>(bits >> num_bits & 0xff);
  }
  return bytes;
}

std::string read_vtk_array(const VtkEncoding& encoding, std::string_view data, bool is_base64) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t width = encoding.long_headers ? 8 : 4;
  // Four letters are three bytes, as far as they are needed to know how many more are.
  const auto letters = [](std::size_t bytes) { return (bytes + 2) / 3 * 4; };
  while (is_base64 && !data.empty() && is_blank(data.front())) data.remove_prefix(1);
  const auto beginning = [&](std::size_t bytes) {
    if (!is_base64) return std::string(data.substr(0, bytes));
    return decode_base64(encoding, data.substr(0, letters(bytes)));
  };
  if (!encoding.zlib) {
    const std::uint64_t length = lengths(encoding, beginning(width), 1)[0];
    if (length > data.size()) fail(encoding, "an array is cut short");
    const std::string all = beginning(width + length);
    if (all.size() < width + length) fail(encoding, "an array is cut short");
    return all.substr(width, length);
  }
  const std::uint64_t blocks = lengths(encoding, beginning(width), 1)[0];
  if (blocks == 0) return {};
  if (blocks > data.size()) fail(encoding, "an array is cut short");
  const std::size_t header_size = width * (3 + blocks);
  const std::vector<std::uint64_t> header = lengths(encoding, beginning(header_size), 3 + blocks);
  if (!is_base64) return expand(encoding, data.substr(header_size), header);
  std::size_t packed = 0;
  for (std::size_t b = 3; b < header.size(); ++b) packed += std::min(header[b], data.size());
  const std::string_view text = data.substr(std::min(letters(header_size), data.size()));
  return expand(encoding, decode_base64(encoding, text.substr(0, letters(packed))), header);
}

std::vector<double> numbers_of(const VtkEncoding& encoding,
                               std::string_view type,
                               std::string_view bytes) {
  if (type == "Float64") return convert<double>(bytes);
  if (type == "Float32") return convert<float>(bytes);
  if (type == "Int64") return convert<std::int64_t>(bytes);
  if (type == "UInt64") return convert<std::uint64_t>(bytes);
  if (type == "Int32") return convert<std::int32_t>(bytes);
  if (type == "UInt32") return convert<std::uint32_t>(bytes);
  if (type == "Int16") return convert<std::int16_t>(bytes);
  if (type == "UInt16") return convert<std::uint16_t>(bytes);
  if (type == "Int8") return convert<std::int8_t>(bytes);
  if (type == "UInt8") return convert<std::uint8_t>(bytes);
  fail(encoding, fmt::format("an array is of type '{}', must be one of VTK's numbers", type));
}

}  // namespace twang
