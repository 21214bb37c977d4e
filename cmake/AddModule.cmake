# add_module(NAME SOURCES ... [PUBLIC targets...] [PRIVATE targets...] [OWN_OPTIONS]): a room of the house, one static library twang_NAME
# (alias twang::NAME), includes from the project's root. Warnings as errors. OWN_OPTIONS: a dependency adds options, as OpenMP does.
function(twang_plain_warnings target)
  if(CMAKE_UNITY_BUILD)
    # Which files share a translation unit is chance: a class whose members have types of its own file is not seen by the others.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
  # g++ 12 takes the inner buffer of a moved string for overrun; the address sanitizer sees what is true.
  target_compile_options(${target} PRIVATE -Wno-array-bounds $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overread>)
endfunction()

# The warnings, and what the preset wants to watch.
function(twang_warnings target)
  twang_plain_warnings(${target})
  if(TWANG_SANITIZE)
    target_compile_options(${target} PRIVATE -O1 -g1)
    # g++ 12 with sanitizers suspects std::regex of uninitialized members; the release build keeps this warning. All of the group "undefined"
    # but what the address sanitizer (null, object-size, pointer-overflow) and Eigen's assertions (alignment) stop at and vptr, for which
    # there are no casts; and the casts of too large numbers besides. The whole group takes half as long again to compile.
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -fsanitize=address
      -fsanitize=bool,bounds,builtin,enum,float-cast-overflow,integer-divide-by-zero,nonnull-attribute,return,returns-nonnull-attribute
      -fsanitize=shift,signed-integer-overflow,unreachable,vla-bound -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=address,undefined)
    # Eigen allocates otherwise under the address sanitizer, and so must not meet itself in libraries built without it, as in Ceres.
    target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
  if(TWANG_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
                                             -fno-omit-frame-pointer)
  endif()
endfunction()

# What nearly every file includes is read once. Files still include what they use: they compile with CMAKE_DISABLE_PRECOMPILE_HEADERS=ON, too.
set(TWANG_COMMON_HEADERS
  <algorithm> <array> <cmath> <complex> <cstddef> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory> <optional> <random>
  <set> <string> <string_view> <utility> <vector> <Eigen/Core> <Eigen/Geometry> <Eigen/LU>)

# The sanitizers watch what is tested; the tests themselves compile in two thirds of the time without them.
function(twang_test_options target)
  if(TWANG_SANITIZE)
    target_compile_options(${target} PRIVATE -fno-sanitize=all)
  endif()
endfunction()

# add_precompiled(NAME HEADERS headers... LIBRARIES targets...): the target twang_precompiled_NAME, whose headers others with the same
# options and definitions reuse.
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/precompiled.cpp CONTENT "")
function(add_precompiled name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBRARIES" ${ARGN})
  add_library(twang_precompiled_${name} OBJECT ${PROJECT_BINARY_DIR}/generated/precompiled.cpp)
  target_link_libraries(twang_precompiled_${name} PRIVATE ${ARG_LIBRARIES})
  target_compile_features(twang_precompiled_${name} PRIVATE cxx_std_20)
  twang_warnings(twang_precompiled_${name})
  target_precompile_headers(twang_precompiled_${name} PRIVATE ${ARG_HEADERS})
endfunction()

function(add_module name)
  cmake_parse_arguments(ARG "OWN_OPTIONS" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(twang_${name} STATIC ${ARG_SOURCES})
  add_library(twang::${name} ALIAS twang_${name})
  target_include_directories(twang_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                  $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>)
  target_link_libraries(twang_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  target_compile_features(twang_${name} PUBLIC cxx_std_20)
  twang_warnings(twang_${name})
  if(ARG_OWN_OPTIONS)
    target_precompile_headers(twang_${name} PRIVATE ${TWANG_COMMON_HEADERS} <fmt/format.h>)
  else()
    target_precompile_headers(twang_${name} REUSE_FROM twang_precompiled_room)
  endif()
endfunction()

# All tests with the label unit: what the sanitizers need to have built.
add_custom_target(unit_tests)

# add_module_test(NAME SOURCES ... [LIBRARIES targets...] [LABEL unit|slow] [TOGETHER] [TIMEOUT seconds] [COST seconds]): a GoogleTest
# program. ctest sees its cases one by one if they are slow; quick ones, which would take longer to start than to run, and those that
# stand on the same long computation (TOGETHER) are one test by the program's name (there, --gtest_filter picks a case).
# Until ctest knows how long a test takes it begins with those of the highest COST, so that no long one is left for the end.
function(add_module_test name)
  cmake_parse_arguments(ARG "TOGETHER" "LABEL;TIMEOUT;COST" "SOURCES;LIBRARIES" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  if(NOT ARG_COST)
    set(ARG_COST 1)
  endif()
  add_executable(test_${name} ${ARG_SOURCES})
  # What the tests of a room include is as much as they are: six at a time they compile in half the time.
  set_target_properties(test_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBRARIES} twang_test_support GTest::gtest GTest::gtest_main)
  target_compile_definitions(test_${name} PRIVATE TWANG_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  twang_warnings(test_${name})
  twang_test_options(test_${name})
  target_compile_options(test_${name} PRIVATE -Wno-shadow)  # a constant of one test is no concern of another's
  target_precompile_headers(test_${name} REUSE_FROM twang_precompiled_test)
  if(ARG_LABEL STREQUAL unit)
    add_dependencies(unit_tests test_${name})
  endif()
  if(ARG_TOGETHER OR ARG_LABEL STREQUAL unit)
    add_test(NAME ${name} COMMAND test_${name})
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} COST ${ARG_COST})
  else()
    gtest_discover_tests(test_${name} DISCOVERY_MODE PRE_TEST
      PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} COST ${ARG_COST})
  endif()
endfunction()
