# Everything comes from Debian packages; nothing is downloaded at configure time.
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(OpenSSL REQUIRED)
if(TWANG_BUILD_FUZZERS)
  return()  # that is all that core and rigs need
endif()
find_package(CLI11 REQUIRED)
find_package(Ceres REQUIRED)
find_package(OpenMP REQUIRED)
find_package(ZLIB REQUIRED)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3)
pkg_check_modules(ARPACK REQUIRED IMPORTED_TARGET arpack)
pkg_check_modules(APRILTAG REQUIRED IMPORTED_TARGET apriltag)

# FFmpeg's headers; its libraries are loaded with the first film.
pkg_check_modules(FFMPEG REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil)
add_library(twang_ffmpeg INTERFACE)
target_include_directories(twang_ffmpeg SYSTEM INTERFACE ${FFMPEG_INCLUDE_DIRS})
target_link_libraries(twang_ffmpeg INTERFACE ${CMAKE_DL_LIBS})

# OpenCV's own CMake package asks for every module; only core and imgproc are used, so they are named here.
find_path(OPENCV_INCLUDE_DIR opencv2/imgproc.hpp PATH_SUFFIXES opencv4 REQUIRED)
find_library(OPENCV_CORE_LIBRARY opencv_core REQUIRED)
find_library(OPENCV_IMGPROC_LIBRARY opencv_imgproc REQUIRED)
add_library(twang_opencv INTERFACE)
target_include_directories(twang_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
target_link_libraries(twang_opencv INTERFACE ${OPENCV_IMGPROC_LIBRARY} ${OPENCV_CORE_LIBRARY})

find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
add_library(twang_cholmod INTERFACE)
target_include_directories(twang_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
target_link_libraries(twang_cholmod INTERFACE ${CHOLMOD_LIBRARY})
