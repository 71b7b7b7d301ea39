# Headers of others that many sources include, read once for each set of compiler options instead
# of once a source. A source still includes what it uses: the check preset builds without this.
#   sixdial_precompiled(name HEADERS <header> ... LIBRARIES ... [OPTIONS ...] [PROGRAM])
#   sixdial_use_precompiled(target name)   gives the target the set and the options it was made with; it
#                                          is linked to the set's libraries for their definitions
# What is precompiled for a library does not fit a program (-fPIC, -fPIE): PROGRAM.

function(sixdial_precompiled name)
  cmake_parse_arguments(ARG "PROGRAM" "" "HEADERS;LIBRARIES;OPTIONS" ${ARGN})
  set(source ${CMAKE_BINARY_DIR}/precompiled_${name}.cpp)
  set(owner sixdial_precompiled_${name})
  if(ARG_PROGRAM)
    file(CONFIGURE OUTPUT ${source} CONTENT "int main() {}\n")
    add_executable(${owner} EXCLUDE_FROM_ALL ${source})
  else()
    file(CONFIGURE OUTPUT ${source} CONTENT "// Only its precompiled headers are used.\n")
    add_library(${owner} STATIC EXCLUDE_FROM_ALL ${source})
  endif()
  target_link_libraries(${owner} PRIVATE sixdial_options ${ARG_LIBRARIES})
  target_compile_options(${owner} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${owner} PRIVATE ${ARG_HEADERS})
  set_target_properties(${owner} PROPERTIES SIXDIAL_LIBRARIES "${ARG_LIBRARIES}")
endfunction()

function(sixdial_use_precompiled target name)
  get_target_property(options sixdial_precompiled_${name} COMPILE_OPTIONS)
  if(options)
    target_compile_options(${target} PRIVATE ${options})
  endif()
  get_target_property(libraries sixdial_precompiled_${name} SIXDIAL_LIBRARIES)
  target_link_libraries(${target} PRIVATE ${libraries})
  target_precompile_headers(${target} REUSE_FROM sixdial_precompiled_${name})
endfunction()

# Computing a lot is worth the time that -O3 takes to build.
sixdial_precompiled(
  numbers
  HEADERS <Eigen/Dense> <tl/expected.hpp> <algorithm> <array> <cmath> <functional> <map> <memory> <numbers>
          <numeric> <optional> <random> <set> <span> <string> <string_view> <thread> <utility> <vector>
  LIBRARIES Eigen3::Eigen tl::expected)
# Waiting for devices, disks and sockets, reading files and writing text is not made faster by -O3.
set(little $<$<CONFIG:Release>:-O1>)
sixdial_precompiled(
  devices
  HEADERS <Eigen/Core> <fmt/format.h> <tl/expected.hpp> <algorithm> <array> <chrono> <cmath> <filesystem>
          <functional> <map> <memory> <mutex> <optional> <random> <span> <sstream> <stop_token> <string>
          <string_view> <thread> <utility> <variant> <vector>
  LIBRARIES Eigen3::Eigen tl::expected fmt::fmt
  OPTIONS ${little})
sixdial_precompiled(
  words
  HEADERS <nlohmann/json.hpp> <fmt/format.h> <Eigen/Core> <tl/expected.hpp> <algorithm> <array> <chrono> <cmath>
          <filesystem> <functional> <map> <memory> <mutex> <optional> <span> <sstream> <stop_token> <string>
          <string_view> <thread> <utility> <vector>
  LIBRARIES Eigen3::Eigen tl::expected fmt::fmt nlohmann_json::nlohmann_json
  OPTIONS ${little})
# Apart from words: whoever includes CLI11 compiles all of it, two seconds a source.
sixdial_precompiled(
  commands
  HEADERS <CLI/CLI.hpp> <nlohmann/json.hpp> <fmt/format.h> <tl/expected.hpp> <algorithm> <chrono> <filesystem>
          <functional> <map> <memory> <optional> <span> <sstream> <string> <string_view> <utility> <vector>
  LIBRARIES tl::expected fmt::fmt nlohmann_json::nlohmann_json CLI11::CLI11
  OPTIONS ${little})
if(SIXDIAL_TESTS)
  sixdial_precompiled(
    tests PROGRAM
    HEADERS <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp> <fmt/format.h> <Eigen/Dense> <tl/expected.hpp>
            <algorithm> <array> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <numbers>
            <optional> <random> <set> <span> <sstream> <string> <string_view> <thread> <utility> <vector>
    LIBRARIES Eigen3::Eigen tl::expected fmt::fmt nlohmann_json::nlohmann_json GTest::gtest GTest::gmock
    OPTIONS ${little})
endif()
