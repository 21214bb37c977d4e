// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace twang {

/// How a VTK XML file holds the numbers of its arrays.
struct VtkEncoding {
  std::string file;           ///< for messages
  bool long_headers = false;  ///< lengths of 8 bytes, else of 4
  bool zlib = false;          ///< arrays are compressed
};

/// Bytes behind base64 text, up to its end or its padding; blanks are skipped.
/// @throws InputError if the text is none
[[nodiscard]] std::string decode_base64(const VtkEncoding& encoding, std::string_view text);

/// Bytes of a binary array from where its length begins.
/// @param is_base64  else raw
/// @throws InputError if the data end too early or cannot be expanded
[[nodiscard]] std::string read_vtk_array(const VtkEncoding& encoding,
                                         std::string_view data,
                                         bool is_base64);

/// Numbers from bytes of VTK's `type` ("Float64", "Int32", ...).
/// @throws InputError for another type
[[nodiscard]] std::vector<double> numbers_of(const VtkEncoding& encoding,
                                             std::string_view type,
                                             std::string_view bytes);

}  // namespace twang
