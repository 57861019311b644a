pathfit_test(golden/mitsuba_reference_test LABEL golden LINK pathfit_app)
