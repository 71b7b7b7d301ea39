# libFuzzer programs for session.csv, plans and rig.toml; included by tests/session.
#   cmake -B build/fuzz -DSIXDIAL_FUZZ=ON -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang
#   cmake --build build/fuzz --target session_csv_fuzz session_rig_fuzz
#   build/fuzz/bin/session_csv_fuzz -max_total_time=600 corpus tests/fuzz/session_csv_corpus
# They compile the parsers (and toml++) anew, so that these are instrumented and nothing else is.
if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "SIXDIAL_FUZZ needs clang: -DCMAKE_CXX_COMPILER=clang++")
endif()
file(GLOB session_parsers ${CMAKE_SOURCE_DIR}/session/*.cpp ${CMAKE_SOURCE_DIR}/geometry/*.cpp)
foreach(fuzzer session_csv_fuzz session_rig_fuzz)
  add_executable(${fuzzer} ${CMAKE_SOURCE_DIR}/tests/fuzz/${fuzzer}.cpp ${session_parsers})
  target_include_directories(${fuzzer} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${fuzzer} PRIVATE Eigen3::Eigen tl::expected fmt::fmt)
  target_compile_options(${fuzzer} PRIVATE -g -O1 -fsanitize=fuzzer,address,undefined
                                           -fno-sanitize-recover=undefined)
  target_link_options(${fuzzer} PRIVATE -fsanitize=fuzzer,address,undefined)
endforeach()
