# What is installed, and Debian packages of it: cmake --install DIR --component onboard|ground|simulator, and cpack.
# bsp/packages/build makes the packages. A build without host programs has the component onboard, the others the rest.
include(GNUInstallDirs)
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(packages ${CMAKE_SOURCE_DIR}/bsp/packages)
set(package_files ${CMAKE_BINARY_DIR}/packages)
# Changes with the commit, whose time the files of a package bear.
set(package_commit ${CMAKE_BINARY_DIR}/bsp/version/commit.inc)

# Manual pages are made of what --help says: always for packages, else by the target man-pages. What was not made is not
# installed.
add_custom_target(man-pages)
function(ilp_page_target target)
  if(ILP_PACKAGE)
    add_custom_target(${target} ALL DEPENDS ${ARGN})
  else()
    add_custom_target(${target} DEPENDS ${ARGN})
  endif()
  add_dependencies(man-pages ${target})
endfunction()
function(ilp_install_page page component)
  set(optional OPTIONAL)
  if(ILP_PACKAGE)
    set(optional "")
  endif()
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component} ${optional})
endfunction()

# ilp_package(COMPONENT PROGRAMS...): programs with their manual pages, and the files that every package has.
function(ilp_package component)
  set(name aerobot-ilp-${component})
  set(pages "")
  foreach(program ${ARGN})
    if(NOT TARGET ${program})
      continue()
    endif()
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
    set(page ${package_files}/${program}.1.gz)
    add_custom_command(OUTPUT ${page} COMMAND ${packages}/man-page ${page} ${program} ${CMAKE_CROSSCOMPILING_EMULATOR}
                       $<TARGET_FILE:${program}> DEPENDS ${program} ${packages}/man-page VERBATIM)
    list(APPEND pages ${page})
    ilp_install_page(${page} ${component})
  endforeach()
  if(ILP_PACKAGE)
    set(log ${package_files}/${name}/changelog.gz)
    add_custom_command(OUTPUT ${log} COMMAND ${packages}/changelog ${log} ${name} ${ILP_PACKAGE_VERSION}
                       DEPENDS ${packages}/changelog ${package_commit} VERBATIM)
    add_custom_target(${name}-files ALL DEPENDS ${log})
    install(FILES ${log} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
  endif()
  ilp_page_target(${component}-pages ${pages})
  install(FILES ${packages}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
  set_property(GLOBAL APPEND PROPERTY ILP_COMPONENTS ${component})
endfunction()

# ilp_package_script(COMPONENT NAME): a command that starts an installed script.
function(ilp_package_script component name)
  install(PROGRAMS ${packages}/${name} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
  set(page ${package_files}/${name}.1.gz)
  add_custom_command(OUTPUT ${page} COMMAND ${packages}/man-page ${page} ${name} ${packages}/${name}
                     DEPENDS ${packages}/man-page ${packages}/${name} ${package_commit} VERBATIM)
  ilp_page_target(${name}-page ${page})
  ilp_install_page(${page} ${component})
endfunction()

# Scripts find each other and their tables where the sources have them.
function(ilp_package_tree component)
  foreach(path ${ARGN})
    get_filename_component(folder ${path} DIRECTORY)
    if(IS_DIRECTORY ${CMAKE_SOURCE_DIR}/${path})
      install(DIRECTORY ${CMAKE_SOURCE_DIR}/${path} DESTINATION ${CMAKE_INSTALL_DATADIR}/aerobot-ilp-${component}/${folder}
              COMPONENT ${component} USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
    else()
      install(FILES ${CMAKE_SOURCE_DIR}/${path} DESTINATION ${CMAKE_INSTALL_DATADIR}/aerobot-ilp-${component}/${folder}
              COMPONENT ${component})
    endif()
  endforeach()
  # Whatever mask the sources were checked out with, everybody may read, and run what can be run.
  set(tree "\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/aerobot-ilp-${component}")
  install(CODE "execute_process(COMMAND chmod -R u=rwX,go=rX \"${tree}\" COMMAND_ERROR_IS_FATAL ANY)"
          COMPONENT ${component})
endfunction()

set(ILP_PACKAGE_VERSION ${PROJECT_VERSION} CACHE STRING "Version of the packages")
if(ILP_HOST_PROGRAMS)
  ilp_package(ground ilp-ground ilp-xtce ilp-store)
  ilp_package_script(ground ilp-merge)
  ilp_package_script(ground ilp-formats)
  ilp_package_script(ground ilp-tiles3d)
  ilp_package_tree(ground sim/tools/cluster sim/tools/python)
  ilp_package(simulator ilp-sil ilp-score ilp-lab ilp-richness)
  ilp_package_script(simulator ilp-campaign)
  ilp_package_tree(simulator sim/tools/campaign sim/tools/cluster sim/campaigns sim/host/metrics.inc
                   sim/ground/report/report_html.cpp)
else()
  ilp_package(onboard ilp-onboard ilp-camera-check)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/cfg/missions DESTINATION ${CMAKE_INSTALL_DATADIR}/aerobot-ilp COMPONENT onboard)
  install(FILES ${packages}/aerobot-ilp-onboard.service DESTINATION lib/systemd/system COMPONENT onboard)
  install(FILES ${packages}/csi-camera.conf DESTINATION ${CMAKE_INSTALL_DATADIR}/aerobot-ilp COMPONENT onboard)
  install(FILES ${packages}/onboard.conf ${packages}/mission.ini DESTINATION /etc/aerobot-ilp COMPONENT onboard)
endif()

set(CPACK_GENERATOR DEB)
get_property(CPACK_COMPONENTS_ALL GLOBAL PROPERTY ILP_COMPONENTS)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_VERSION ${ILP_PACKAGE_VERSION})
set(CPACK_PACKAGE_CONTACT "aerobot ILP maintainers <maintainers@aerobot-ilp.invalid>")
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
endif()
set(CPACK_DEBIAN_ONBOARD_PACKAGE_NAME aerobot-ilp-onboard)
set(CPACK_DEBIAN_GROUND_PACKAGE_NAME aerobot-ilp-ground)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_NAME aerobot-ilp-simulator)
set(CPACK_COMPONENT_ONBOARD_DESCRIPTION "flight software of a balloon's imaging package
Localises the images of one camera, computes elevation maps and sends
compressed products. One static program with a unit for systemd.")
set(CPACK_COMPONENT_GROUND_DESCRIPTION "ground segment of a balloon's imaging package
Merges products into one terrain model with reports and a viewer, operates
the flight over its link, and writes its XTCE database.")
set(CPACK_COMPONENT_SIMULATOR_DESCRIPTION "simulator of a balloon's imaging package
Flies the flight software over simulated or recorded images, scores the
results, and runs its kernels and campaigns from the command line.")
set(CPACK_DEBIAN_ONBOARD_PACKAGE_CONTROL_EXTRA ${packages}/postinst ${packages}/prerm ${packages}/postrm ${packages}/conffiles)
set(CPACK_DEBIAN_GROUND_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_GROUND_PACKAGE_DEPENDS python3)
# ilp-formats and ilp-tiles3d need them, and say so.
set(CPACK_DEBIAN_GROUND_PACKAGE_RECOMMENDS "python3-numpy, python3-gdal")
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_DEPENDS python3)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_RECOMMENDS aerobot-ilp-ground)
include(CPack)
