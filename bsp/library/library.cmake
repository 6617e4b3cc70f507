# The kernels of fsw/vision as a package of CMake for other projects: cmake --install DIR --component library
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(ILP_LIBRARY_HEADERS ${CMAKE_INSTALL_INCLUDEDIR}/ilp_vision)
set(ILP_LIBRARY_CONFIG ${CMAKE_INSTALL_LIBDIR}/cmake/ilp_vision)

get_property(libraries GLOBAL PROPERTY ILP_FLIGHT_LIBRARIES)
list(FILTER libraries INCLUDE REGEX "^(ilp_base|ilp_vision_.*)$")
add_library(ilp_vision INTERFACE)
target_link_libraries(ilp_vision INTERFACE ${libraries})
target_include_directories(ilp_vision INTERFACE $<INSTALL_INTERFACE:${ILP_LIBRARY_HEADERS}>)
target_compile_features(ilp_vision INTERFACE cxx_std_20)
add_custom_target(library DEPENDS ilp_vision_stereo ${libraries})
install(TARGETS ilp_vision ilp_vision_stereo ilp_settings ${libraries} EXPORT ilp_vision COMPONENT library
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/ilp_vision)
install(EXPORT ilp_vision NAMESPACE ilp:: DESTINATION ${ILP_LIBRARY_CONFIG} COMPONENT library)

install(FILES ${CMAKE_SOURCE_DIR}/cfg/limits.hpp ${CMAKE_SOURCE_DIR}/cfg/choices.hpp ${ILP_PROFILE_FOLDER}/profile.hpp
        DESTINATION ${ILP_LIBRARY_HEADERS}/cfg COMPONENT library)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/fsw/base ${CMAKE_SOURCE_DIR}/fsw/vision DESTINATION ${ILP_LIBRARY_HEADERS}/fsw
        COMPONENT library FILES_MATCHING PATTERN "*.hpp" PATTERN "status_list.inc")

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/config.cmake ${CMAKE_BINARY_DIR}/library/ilp_visionConfig.cmake
                              INSTALL_DESTINATION ${ILP_LIBRARY_CONFIG})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/library/ilp_visionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/library/ilp_visionConfig.cmake ${CMAKE_BINARY_DIR}/library/ilp_visionConfigVersion.cmake
        DESTINATION ${ILP_LIBRARY_CONFIG} COMPONENT library)
