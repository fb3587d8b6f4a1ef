showSummary();
showMatrix();
showGallery();
showCharts();
showTable();
showSetup();
showPictures();
