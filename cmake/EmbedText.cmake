# embed_texts(TARGET NAMESPACE namespace HEADER header.hpp TEXTS kName=file ...): files as C++ string literals of TARGET, declared in
# the generated header as `extern const std::string_view kName`. A changed file is embedded anew at the next build.
function(embed_texts target)
  cmake_parse_arguments(ARG "" "NAMESPACE;HEADER" "TEXTS" ${ARGN})
  set(script ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embed_text_script.cmake)
  set(declarations)
  foreach(entry ${ARG_TEXTS})
    string(REGEX MATCH "^([^=]+)=(.+)$" matched "${entry}")
    if(NOT matched)
      message(FATAL_ERROR "embed_texts: \"${entry}\" must be kName=file")
    endif()
    set(name ${CMAKE_MATCH_1})
    get_filename_component(file "${CMAKE_MATCH_2}" ABSOLUTE)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/${target}_${name}.cpp)
    add_custom_command(
      OUTPUT ${source}
      COMMAND ${CMAKE_COMMAND} -DTEXT_FILE=${file} -DTEXT_NAME=${name} -DTEXT_NAMESPACE=${ARG_NAMESPACE}
              -DTEXT_HEADER=${ARG_HEADER} -DTEXT_OUTPUT=${source} -P ${script}
      DEPENDS ${file} ${script}
      VERBATIM)
    target_sources(${target} PRIVATE ${source})
    string(APPEND declarations "extern const std::string_view ${name};\n")
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/${ARG_HEADER} @ONLY CONTENT
"// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace @ARG_NAMESPACE@ {

@declarations@
}  // namespace @ARG_NAMESPACE@
")
endfunction()
