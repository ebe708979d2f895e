;;; SPDX-License-Identifier: GPL-3.0-or-later
;;; In the folder above: guix build -f guix/hdengine.scm
(use-modules ((guix licenses) #:prefix license:)
             (guix build-system pyproject)
             (guix gexp)
             (guix packages)
             (gnu packages algebra)
             (gnu packages build-tools)
             (gnu packages gcc)
             (gnu packages maths)
             (gnu packages pkg-config)
             (gnu packages python-xyz))

(package
  (name "hdengine")
  (version "@version@")
  ;; Once hdengine has an address: an origin with url-fetch.
  (source (local-file "../hdengine-@version@.tar.gz"))
  (build-system pyproject-build-system)
  (arguments
   (list #:tests? #f                    ;they take minutes; ./hd test runs them
         #:configure-flags
         #~(list (cons "setup-args"
                       (vector (string-append "-Dinclude_path="
                                              #$(this-package-input "mumps")
                                              "/include")
                               (string-append "-Dlibrary_path="
                                              #$(this-package-input "mumps")
                                              "/lib"))))))
  (native-inputs (list gfortran meson-python pkg-config))
  (inputs (list fftw fftwf metis mumps openblas))
  (propagated-inputs (list python-numpy))
  (home-page "https://doi.org/10.3389/fmats.2023.1211019") ;the model's paper
  (synopsis "Torsional stiffness of harmonic drives")
  (description
   "hdengine computes the contact between flexspline and flexible bearing of
a harmonic drive, and the torsional stiffness that it leaves.")
  (license license:gpl3+))
