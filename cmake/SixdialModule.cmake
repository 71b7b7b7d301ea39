# sixdial_module(name PRECOMPILED set LIBRARIES ...): one static library from every *.cpp of a folder
# and its sub-folders; its compiler options are those of the set (Precompiled.cmake). TOGETHER n: so many
# sources are compiled as one, where each alone would instantiate the same templates again; ALONE regex: but
# not these. A name in an anonymous namespace stands once in such a folder then. sixdial_tests(name LIBRARIES ...): one GoogleTest program from tests/<name>/*.cpp.

add_library(sixdial_options INTERFACE)
target_include_directories(sixdial_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(
  sixdial_options
  INTERFACE -Wall -Wextra -Wpedantic -Werror -Wconversion -Wsign-conversion -Wshadow
            -Wdouble-promotion -Wnon-virtual-dtor -Woverloaded-virtual)
target_compile_definitions(sixdial_options INTERFACE SIXDIAL_VERSION="${PROJECT_VERSION}")
if(SIXDIAL_SANITIZE)
  # Sanitized code makes g++ 12 see overflows that are none (stringop-overflow): warnings only.
  target_compile_options(sixdial_options INTERFACE -Wno-error -fsanitize=${SIXDIAL_SANITIZE}
                                                   -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_compile_definitions(sixdial_options INTERFACE SIXDIAL_SANITIZED)
  if(SIXDIAL_SANITIZE MATCHES address)
    # The standard library's own checks too: an empty optional, an index outside of a vector.
    target_compile_definitions(sixdial_options INTERFACE _GLIBCXX_ASSERTIONS)
  endif()
  target_link_options(sixdial_options INTERFACE -fsanitize=${SIXDIAL_SANITIZE})
endif()

find_program(SIXDIAL_CCACHE ccache)
if(SIXDIAL_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SIXDIAL_CCACHE})
  # Without these ccache keeps nothing that was compiled with a precompiled header.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-fpch-preprocess)
  else()
    add_compile_options("SHELL:-Xclang -fno-pch-timestamp")
  endif()
endif()

function(sixdial_module name)
  cmake_parse_arguments(ARG "" "PRECOMPILED;TOGETHER;ALONE" "LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(sixdial_${name} STATIC ${sources})
  add_library(sixdial::${name} ALIAS sixdial_${name})
  target_link_libraries(sixdial_${name} PUBLIC sixdial_options ${ARG_LIBRARIES})
  sixdial_use_precompiled(sixdial_${name} ${ARG_PRECOMPILED})
  if(ARG_TOGETHER AND SIXDIAL_TOGETHER)
    set_target_properties(sixdial_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ARG_TOGETHER})
    if(ARG_ALONE)
      list(FILTER sources INCLUDE REGEX ${ARG_ALONE})
      set_source_files_properties(${sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endif()
endfunction()

function(sixdial_tests name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/${name}/*.cpp)
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE sixdial_options sixdial_test_paths ${ARG_LIBRARIES}
                                             GTest::gtest GTest::gmock GTest::gtest_main)
  sixdial_use_precompiled(test_${name} tests)
  # Ten minutes are a test that hangs; with a sanitizer everything takes ten times longer.
  set(longest_s 600)
  if(SIXDIAL_SANITIZE)
    set(longest_s 1200)
  endif()
  gtest_discover_tests(test_${name} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 120
                       PROPERTIES TIMEOUT ${longest_s} LABELS ${name})
endfunction()
