# add_module(NAME SOURCES ... [PUBLIC targets...] [PRIVATE targets...]): a room of the house, one static library twang_NAME
# (alias twang::NAME), includes from the project's root. Warnings as errors.
function(twang_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
  if(TWANG_SANITIZE)
    # g++ 12 with sanitizers suspects std::regex of uninitialized members; the release build keeps this warning. What null and object-size
    # would find the address sanitizer stops at, and there are no casts for vptr to check: without them files compile a seventh faster.
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -fsanitize=address,undefined -fno-sanitize=null,object-size,vptr
                                             -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=address,undefined)
  endif()
  if(TWANG_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
                                             -fno-omit-frame-pointer)
  endif()
endfunction()

function(add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(twang_${name} STATIC ${ARG_SOURCES})
  add_library(twang::${name} ALIAS twang_${name})
  target_include_directories(twang_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                  $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>)
  target_link_libraries(twang_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  target_compile_features(twang_${name} PUBLIC cxx_std_20)
  twang_warnings(twang_${name})
endfunction()

# All tests with the label unit: what the sanitizers need to have built.
add_custom_target(unit_tests)

# add_module_test(NAME SOURCES ... [LIBRARIES targets...] [LABEL unit|slow] [TIMEOUT seconds] [COST seconds] [WHOLE]): a GoogleTest
# program. ctest sees its cases one by one if they are slow; quick ones, which would take longer to start than to run, and those of a
# program marked WHOLE, which share what is computed once, are one test by the program's name (there, --gtest_filter picks a case).
# Until ctest knows how long a test takes it begins with those of the highest COST, so that no long one is left for the end.
function(add_module_test name)
  cmake_parse_arguments(ARG "WHOLE" "LABEL;TIMEOUT;COST" "SOURCES;LIBRARIES" ${ARGN})
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
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBRARIES} twang_test_support GTest::gtest GTest::gtest_main)
  target_compile_definitions(test_${name} PRIVATE TWANG_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  twang_warnings(test_${name})
  if(ARG_LABEL STREQUAL unit)
    add_dependencies(unit_tests test_${name})
  endif()
  if(ARG_WHOLE OR ARG_LABEL STREQUAL unit)
    add_test(NAME ${name} COMMAND test_${name})
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} COST ${ARG_COST})
  else()
    gtest_discover_tests(test_${name} DISCOVERY_MODE PRE_TEST
      PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} COST ${ARG_COST})
  endif()
endfunction()
