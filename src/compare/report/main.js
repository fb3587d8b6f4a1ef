showSummary();
showMatrix();
showCharts();
showTable();
showSetup();
showPictures();
