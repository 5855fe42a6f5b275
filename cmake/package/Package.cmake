# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack, one for each install component: README.md. Built by `./dev package`.
set(TTFBOX_DEPENDS_tools "" CACHE STRING "What package ttfbox depends on (dpkg-shlibdeps, by ./dev package)")
set(TTFBOX_DEPENDS_box "" CACHE STRING "The same of ttfbox-box")
set(TTFBOX_DEPENDS_libcamera "" CACHE STRING "The same of ttfbox-libcamera")
set(TTFBOX_ARCHITECTURE amd64 CACHE STRING "Debian's name of the processor built for")

include(GNUInstallDirs)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ttfbox)
set(CPACK_PACKAGE_VENDOR ttfbox)
set(CPACK_PACKAGE_CONTACT "ttfbox maintainers <maintainers@ttfbox.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL tools box libcamera)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${TTFBOX_ARCHITECTURE})
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# Files are 0644 or 0755 whatever the builder's umask is.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME ttfbox)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS "${TTFBOX_DEPENDS_tools}")
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS "ffmpeg, tzdata")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "calibrated time-lapse datasets and textures that evolve
ttfbox captures a sample at fixed intervals, keeps what it captured as a
calibrated dataset, verifies, develops and exports it, and synthesizes larger
textures from it that evolve coherently in time.

This package has the command ttfbox, which also runs a simulated box.")

set(CPACK_DEBIAN_BOX_PACKAGE_NAME ttfbox-box)
set(CPACK_DEBIAN_BOX_PACKAGE_SECTION electronics)
set(CPACK_DEBIAN_BOX_PACKAGE_DEPENDS
    "${TTFBOX_DEPENDS_box}, ttfbox (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}), systemd, tzdata")
set(CPACK_DEBIAN_BOX_PACKAGE_RECOMMENDS "iproute2 | busybox")
set(CPACK_DEBIAN_BOX_PACKAGE_SUGGESTS "gpiod, v4l-utils, mosquitto-clients, msmtp-mta")
set(CPACK_DEBIAN_BOX_PACKAGE_CONTROL_EXTRA
    ${CMAKE_CURRENT_LIST_DIR}/box/postinst ${CMAKE_CURRENT_LIST_DIR}/box/prerm
    ${CMAKE_CURRENT_LIST_DIR}/box/postrm)
set(CPACK_COMPONENT_BOX_DESCRIPTION "services of a ttfbox capture box
ttfboxd runs a plan unattended from boot to boot and goes on with it after a
power cut; ttfbox-lampd is the lamp guardian, the only process that holds a
box's lamp lines. Both are hardened services of unprivileged users.
ttfbox-gadget makes the box a USB device with a network and an interface that
ttfbox-usbd serves, so that a PC pulls datasets over the cable.

Nothing is captured before /etc/ttfbox/ttfboxd.yaml is written and the
services are enabled.")

set(CPACK_DEBIAN_LIBCAMERA_PACKAGE_NAME ttfbox-libcamera)
set(CPACK_DEBIAN_LIBCAMERA_PACKAGE_SECTION electronics)
# libcamera's pipelines have their algorithms in a package of their own.
set(CPACK_DEBIAN_LIBCAMERA_PACKAGE_DEPENDS
    "${TTFBOX_DEPENDS_libcamera}, libcamera-ipa, ttfbox (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_COMPONENT_LIBCAMERA_DESCRIPTION "ttfbox with cameras behind libcamera
The module by which ttfbox and ttfboxd reach cameras that need libcamera, as
the camera modules of a Raspberry Pi do. It is made for this system's version
of libcamera and no other.")

# What Debian wants beside the files. Only here: an installation by hand has no use for it.
set(notes ${PROJECT_BINARY_DIR}/package)
file(MAKE_DIRECTORY ${notes})
execute_process(COMMAND gzip -9nc ${CMAKE_CURRENT_LIST_DIR}/changelog
                OUTPUT_FILE ${notes}/changelog.Debian.gz COMMAND_ERROR_IS_FATAL ANY)
foreach(page IN ITEMS ttfboxd.8 ttfbox-lampd.8 ttfbox-usbd.8 ttfbox-gadget.8 ttfbox-preview.8 ttfbox-alertd.8)
    execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/firmware/units/${page}
                    OUTPUT_FILE ${notes}/${page}.gz COMMAND_ERROR_IS_FATAL ANY)
    install(FILES ${notes}/${page}.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man8 COMPONENT box)
endforeach()
foreach(part IN ITEMS tools:ttfbox box:ttfbox-box libcamera:ttfbox-libcamera)
    string(REPLACE ":" ";" part ${part})
    list(GET part 0 component)
    list(GET part 1 package)
    install(FILES ${notes}/changelog.Debian.gz ${CMAKE_CURRENT_LIST_DIR}/copyright
            DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
    install(FILES ${CMAKE_CURRENT_LIST_DIR}/overrides/${package}
            DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides COMPONENT ${component})
endforeach()
include(CPack)
