# Observable Plot and d3 for the report, by `npm ci` from a committed lock, at build time.
#   cmake -DWEB=report/web -DWORK=build/…/web -DNPM=npm -DHEADER=… -DNAMESPACE=… -DOUTPUT=out.cpp -P ChartLibraries.cmake
# Without npm, or if it fails, OUTPUT holds empty texts: reports then have tables only and say so.
# Run at each build: it does nothing once the libraries of this lock are there, and tries again else.
cmake_minimum_required(VERSION 3.25)
set(modules ${WORK}/node_modules)
set(d3 ${modules}/d3/dist/d3.min.js)
set(plot ${modules}/@observablehq/plot/dist/plot.umd.min.js)
set(licences ${WORK}/licences.txt)
file(SHA256 ${WEB}/package-lock.json lock)
set(have "")
if(EXISTS ${WORK}/lock.sha256)
  file(READ ${WORK}/lock.sha256 have)
endif()

if(NOT have STREQUAL lock OR NOT EXISTS ${d3} OR NOT EXISTS ${plot})
  file(REMOVE ${WORK}/lock.sha256 ${licences})
  set(trouble "npm was not found")
  if(NPM)
    file(MAKE_DIRECTORY ${WORK})
    file(COPY ${WEB}/package.json ${WEB}/package-lock.json ${WEB}/.npmrc DESTINATION ${WORK})
    execute_process(
      COMMAND ${NPM} ci --no-audit --no-fund --ignore-scripts
      WORKING_DIRECTORY ${WORK} TIMEOUT 180
      RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
    if(result EQUAL 0 AND EXISTS ${d3} AND EXISTS ${plot})
      set(trouble "")
    else()
      set(trouble "`npm ci` failed (${result}): ${said}")
    endif()
  endif()
  if(trouble)
    message("report: no chart library, reports will have tables only. ${trouble}")
    file(REMOVE_RECURSE ${modules})
  else()
    # Plot's ready file holds the three small packages as well: each licence goes along.
    set(text "")
    foreach(package d3 @observablehq/plot interval-tree-1d binary-search-bounds isoformat)
      file(READ ${modules}/${package}/LICENSE licence)
      string(APPEND text "${package}\n${licence}\n")
    endforeach()
    file(WRITE ${licences} "${text}")
    file(WRITE ${WORK}/lock.sha256 ${lock})
  endif()
endif()

set(FILES "d3_js=${d3}|plot_js=${plot}|licences=${licences}")
include(${CMAKE_CURRENT_LIST_DIR}/EmbedFile.cmake)
